"""Replay of recordings: the console's panels, showing a recorded robot."""
