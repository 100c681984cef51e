"""Recordings played back in the panels of the console."""
