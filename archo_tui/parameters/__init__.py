"""ROS parameter files: those given at the start, and saving and loading later."""
