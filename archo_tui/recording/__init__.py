"""The black box: what was heard in the last minute, written as a ROS bag when something happens."""
