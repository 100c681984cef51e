"""Recordings played back: the same panels on a recorded robot."""
