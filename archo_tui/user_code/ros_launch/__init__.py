"""ROS 2 launch files and workspaces read without ROS: what a launch file would start."""
