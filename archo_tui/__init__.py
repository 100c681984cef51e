"""archo-tui: an interactive terminal console for the warehouse robot ARCHO."""

__version__ = "0.1.0"
