"""The operator's side of the ROS graph. Knows no Textual and holds no node object."""
