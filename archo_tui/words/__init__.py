"""What is said of the robot: every state as glyph, word and tone. Pure."""
