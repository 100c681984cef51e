"""A model of ARCHO's battery: voltage, charge and health. The charge is in %, 0 .. 100."""

from __future__ import annotations

START = 87.5  # In %: the textbook's first reading.
HYSTERESIS = 3.0  # In %: a warning ends this far above the threshold, so it does not flap.

GOOD, WARNING = "good", "warning"


def voltage(percentage: float) -> float:
    """Return the voltage at the terminals: 20.6 V empty, 24.6 V full, 24.1 V at 87.5 %."""
    return 20.6 + 0.04 * percentage


def changed(percentage: float, by: float) -> float:
    """Return the charge after adding `by` %, which may be negative, kept within 0 .. 100."""
    return min(max(percentage + by, 0.0), 100.0)


def health(percentage: float, threshold: float, before: str) -> str:
    """Return `warning` below the threshold (%), `good` again HYSTERESIS above it, else `before`."""
    if percentage < threshold:
        return WARNING
    if percentage >= min(threshold + HYSTERESIS, 100.0):
        return GOOD
    return before
