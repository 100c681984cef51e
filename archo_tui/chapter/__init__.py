"""`archo-tui check`: the textbook's chapter, asked of nodes."""
