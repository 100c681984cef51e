"""ROS 2 workspaces read without ROS: their packages, executables and share folders."""
