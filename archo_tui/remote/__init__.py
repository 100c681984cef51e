"""How other programs of the same user reach a console: its socket, the shell, Python."""
