"""What other programs reach: the socket, the shell, Python."""
