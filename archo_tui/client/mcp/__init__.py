"""The Model Context Protocol server through which a language model uses the console.

It runs in a process of its own, and can read, ask for goals and STOP. A person at the console
decides whether anything moves, and the console enforces that: nothing in here can allow a goal.
"""
