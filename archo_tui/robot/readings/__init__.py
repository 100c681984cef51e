"""The readings of battery, motion, pose, gauges and diagnostics."""
