"""What the screen is made of. Widgets know the robot's state and nothing of ROS."""
