"""Who operates the robot: other consoles, other clients, and who requests something here."""
