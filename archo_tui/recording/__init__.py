"""The black box: the last minute of messages, written as a ROS bag when something happens."""
