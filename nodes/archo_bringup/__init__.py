"""The nodes of the warehouse robot ARCHO."""
