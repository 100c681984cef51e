"""The texts of all frontends: the robot's states as glyph, word and tone. Pure functions."""
