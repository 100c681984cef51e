"""Each screen as a picture, and how it is drawn."""
