"""The engines: real ROS 2, or the embedded one."""
