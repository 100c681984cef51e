"""An assistant at the console, over the Model Context Protocol: a process of its own.

It reads, asks and stops. Whether anything moves is decided by a person at the console, and
enforced there: nothing in here can allow it.
"""
