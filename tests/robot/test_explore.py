"""STOP, explored to the last state of small worlds; and each rule broken on purpose is found."""

from __future__ import annotations

import pytest

from archo_tui.robot.stop import machine
from tests.robot.explore import SMALL, WORLDS, explore, unvisited
from tests.robot.exploring import broken, source_of

SOURCE = source_of(machine)

RELEASE, RESTART = "two servers and a release", "two servers and a restart"
STOPS, PEER = "two STOPs and a release", "a peer and a release"
SUSPENDED = "two servers, of which one is suspended"
REPORTED_PEER = "a peer's release and ours of a robot that reports its stop"
REPORTS = "a robot that reports its stop, and a restart"
# A rule, what it says instead, and the world in which that is found.
BROKEN = [
    # A yes to a call before the open STOP confirms nothing.
    ("if is_earlier or (", "if (", STOPS),
    # A late yes behind a release is not certain.
    ("YES_TO_PAST:    (_D,", "YES_TO_PAST:    (_H,", RELEASE),
    # A release that may have come last leaves a doubt, and earlier calls confirm nothing.
    ("MAY_BE_RELEASED: (_N, _D,", "MAY_BE_RELEASED: (_N, _H,", RELEASE),
    ("after._replace(first_turn=turn, open=", "after._replace(open=", RELEASE),
    ("after = self._replace(past_turn=turn)", "after = self", RELEASE),
    # Nodes that came since the call left have not confirmed it.
    ("turn, now, turn_now, asked, here)", "turn, now, turn_now, servers, here)", RESTART),
    (
        "            return held.served_by(servers, here, now)\n",
        "            return held\n",
        RESTART,
    ),
    # A restart of its node makes a STOP uncertain.
    ("SERVERS_DIFFER: (_X, _U,", "SERVERS_DIFFER: (_X, _H,", "a peer and a restart"),
    # A node that left without an answer has not confirmed it.
    ("        if held.state is not State.HELD or not silent:\n", "        if True:\n", SUSPENDED),
    # The robot's own report ends a STOP.
    ("SAYS_RELEASED:  (_X, _N,", "SAYS_RELEASED:  (_X, _H,", REPORTS),
    # Another console's STOP that crosses a release is not certain.
    (" and self.undone_by != console", " and False", PEER),
    ("turn > self.peer_turn:", "True:", PEER),
    # So is another console's release that crosses it.
    ("if is_held and self.peer == console:", "if is_held:", PEER),
    (
        "if is_held and self.peer == console:",
        "if is_held and (self.reports or self.peer == console):",
        REPORTED_PEER,
    ),
    # Never two calls at once; a refusal is asked again.
    ("or self.awaited:", "or False:", RELEASE),
    ("open.answer is StopAnswer.UNCONFIRMED and", "open.answer is StopAnswer.REFUSED or", RELEASE),
    # Goals from before a STOP are cancelled, whatever it is answered; those of others, too.
    ("opened._cancel_before(turn, now)", "opened", "a goal and a release"),
    ("return now - stop.asked >= CANCEL_OTHERS_AFTER", "return False", RELEASE),
    # Nothing starts behind a STOP that is open, holds, or is in doubt.
    ("return self.open is None and self.state is State.NONE", "return self.open is None", RELEASE),
    (
        "return self.open is None and self.state is State.NONE",
        "return self.state is State.NONE",
        RELEASE,
    ),
    (
        "return self.open is None and self.state is State.NONE",
        "return self.open is None and self.state is not State.HELD",
        RESTART,
    ),
    # All of that ends when the STOP is given up.
    ("open=None, others_before=0, is_given_up=True", "open=None, is_given_up=True", RELEASE),
    ("and not self.is_given_up", "", RELEASE),
]


@pytest.mark.parametrize("name", SMALL)
def test_every_promise_holds_in_every_state(name: str) -> None:
    found, _ = explore(WORLDS[name]())
    assert found.broken == "", found.way


def test_each_rule_that_can_be_broken_is_found_in_the_machine() -> None:
    assert [before for before, _, _ in BROKEN if SOURCE.count(before) != 1] == []


@pytest.mark.night
def test_every_promise_holds_in_every_state_of_larger_worlds_too() -> None:
    cells: set[tuple[str, str]] = set()
    for make in WORLDS.values():
        found, visited = explore(make())
        assert found.broken == "", found.way
        cells |= visited
    assert unvisited(cells) == []


@pytest.mark.night
@pytest.mark.parametrize(("before", "after", "name"), BROKEN)
def test_a_broken_rule_is_found(before: str, after: str, name: str) -> None:
    found, _ = explore(WORLDS[name](module=broken(machine, before, after)))
    assert found.broken != ""
