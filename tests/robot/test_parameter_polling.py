"""Parameters that are read again: each once in a round, in slices, a few questions at a look."""

from __future__ import annotations

from typing import Any

import pytest

from archo_tui.robot.graph.parameters import MAX_REQUESTS, PERIOD, SLICE, ParameterPolling

pytestmark = pytest.mark.pure


def looks(rounds: ParameterPolling, names: dict[str, list[str]], since: float) -> list[list[Any]]:
    """What is read in a round of looks, one a second."""
    return [rounds.take_due(since + second, names) for second in range(int(PERIOD))]


def test_each_parameter_is_read_once_in_thirty_seconds() -> None:
    rounds = ParameterPolling()
    names = {"/b": ["one"], "/a": ["two", "three"], "/large": [str(n) for n in range(SLICE + 1)]}
    for since in (0.0, PERIOD):
        read = [slice for look in looks(rounds, names, since) for slice in look]
        assert [node for node, _ in read] == ["/a", "/b", "/large", "/large"]
        assert [len(some) for _, some in read] == [2, 1, SLICE, 1]


def test_a_crowd_is_read_a_few_at_a_look_however_long_it_takes() -> None:
    rounds, crowd = ParameterPolling(), {f"/{number:04}": ["one"] for number in range(1000)}
    read = [
        slice
        for since in range(0, 300, 30)
        for look in looks(rounds, crowd, since)
        for slice in look
    ]
    assert max(len(look) for look in looks(rounds, crowd, 300.0)) <= MAX_REQUESTS
    assert len({node for node, _ in read}) == 1000
