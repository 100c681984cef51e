"""Parameters in files and back, and changes that can be undone."""
