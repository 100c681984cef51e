"""The mouths of the console: the sessions of its clients, the socket, and `--plain`."""
