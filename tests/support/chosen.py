"""The engine that the whole run uses, and domains of its own for each test."""

from __future__ import annotations

import itertools
import os

ENGINE = "embedded"

# DDS allows for little more than 100 domains; each of two workers has its half of them
_FIRST = 1 + 50 * (os.environ.get("PYTEST_XDIST_WORKER", "gw0") != "gw0")
_domains = itertools.cycle(range(_FIRST, _FIRST + 49))


def next_domain() -> int:
    """Another domain: no test hears a neighbour."""
    return next(_domains)
