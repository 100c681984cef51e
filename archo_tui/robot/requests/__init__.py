"""The requests to the robot: functions over its parts, called on the event loop.

Each ends within a deadline: done, refused with the reason, or without an answer.
"""
