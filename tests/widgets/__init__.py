"""The panels, and the fields and lists in them."""
