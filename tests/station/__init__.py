"""Alarms, history, journal and the end: what is known beside the robot."""
