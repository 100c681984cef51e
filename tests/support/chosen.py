"""The engine that the whole run uses, and domains of its own for each test."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator

ENGINE = "embedded"

# DDS allows for little more than 100 domains; each of twelve workers has its part of them
_EACH = 8
_domains: Iterator[int]


def use_domains_of(worker: int) -> None:
    """Take domains that no other process of this run uses.

    Args:
        worker: The number of this process among those that run tests.
    """
    global _domains
    first = 1 + _EACH * (worker % 12)
    _domains = itertools.cycle(range(first, first + _EACH))


use_domains_of(int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")))


def next_domain() -> int:
    """Another domain: no test hears a neighbour."""
    return next(_domains)
