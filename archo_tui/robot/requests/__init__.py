"""The requests to the robot: functions over its parts, called on the loop, with a deadline each."""
