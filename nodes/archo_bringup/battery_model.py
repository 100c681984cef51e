"""How ARCHO's battery drains, charges and is judged. Percent of full throughout, 0 .. 100."""

from __future__ import annotations

START = 87.5  # %, the textbook's first reading
HYSTERESIS = 3.0  # %; a warning clears this far above the threshold, so that it does not flap

GOOD, WARNING = "good", "warning"


def voltage(percentage: float) -> float:
    """Volts at the terminals: 20.6 V empty, 24.6 V full; 87.5 % is 24.1 V."""
    return 20.6 + 0.04 * percentage


def changed(percentage: float, by: float) -> float:
    """The charge after taking or giving `by` %, which never leaves 0 .. 100."""
    return min(max(percentage + by, 0.0), 100.0)


def health(percentage: float, threshold: float, before: str) -> str:
    """`warning` below the threshold (%), `good` again HYSTERESIS above it, else as `before`."""
    if percentage < threshold:
        return WARNING
    if percentage >= min(threshold + HYSTERESIS, 100.0):
        return GOOD
    return before
