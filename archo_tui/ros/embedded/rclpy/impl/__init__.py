"""The package `rclpy.impl`, which holds the class of loggers."""
