"""`archo-tui --plain`: the frontend that reads and prints line by line."""
