"""As in rclpy: the room of the logger class."""
