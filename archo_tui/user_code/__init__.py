"""Running nodes in this process: the robot's own, and those of the user's files."""
