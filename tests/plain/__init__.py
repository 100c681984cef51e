"""The console line by line, on standard input and output."""
