"""`archo-tui check`: tests whether nodes do what the textbook's chapter asks for."""
