"""`archo-tui check`: what the textbook asks of a learner's nodes."""
