"""The textbook's listings, as printed: they must run unchanged."""
