"""The Model Context Protocol server through which a language model uses the console.

It runs in a process of its own. It reads, requests and stops. Whether anything moves is decided by
a person at the console, and enforced there: nothing in here can allow it.
"""
