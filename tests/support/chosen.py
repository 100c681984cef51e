"""The engine that the whole run uses, and domains of its own for each test."""

from __future__ import annotations

import itertools

ENGINE = "embedded"

_domains = itertools.cycle(range(1, 100))  # DDS allows for little more than 100


def next_domain() -> int:
    """Another domain: no test hears a neighbour."""
    return next(_domains)
