"""The ways by which other programs of the same user reach a console: socket, shell, Python."""
