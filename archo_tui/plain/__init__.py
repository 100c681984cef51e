"""`archo-tui --plain`: the station line by line."""
