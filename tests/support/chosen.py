"""The engine that the whole run uses, and domains of its own for each test."""

from __future__ import annotations

import itertools
import os

ENGINE = "embedded"

# DDS allows for little more than 100 domains; each of six workers has its part of them
_WORKER = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
_EACH = 16
_FIRST = 1 + _EACH * (_WORKER % 6)
_domains = itertools.cycle(range(_FIRST, _FIRST + _EACH))


def next_domain() -> int:
    """Another domain: no test hears a neighbour."""
    return next(_domains)
