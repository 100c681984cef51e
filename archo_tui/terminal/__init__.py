"""What stands between the console and its terminal."""
