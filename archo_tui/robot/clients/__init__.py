"""The clients of the robot: consoles, what others change, and the requesters here."""
