"""Recordings: the last minute of messages as a ROS bag when something happens, and all of them."""
