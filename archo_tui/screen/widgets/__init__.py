"""The widgets of the screen. They know the robot's state, and nothing of ROS."""
