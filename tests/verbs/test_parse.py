"""Words as values: what each verb needs and takes, and its JSON Schema for programs."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

import pytest

from archo_tui.base.errors import ArchoError
from archo_tui.robot.messages.types import TypedField
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file.model import FormField, GoalKind
from archo_tui.verbs import verbs
from archo_tui.verbs.goals import GOALS, Go
from archo_tui.verbs.verb import named, parse, prepare_when_found
from tests.support.archo import ARCHO, FORMS, SHELF
from tests.support.states import NORMAL, board
from tests.support.stub import StandingClock, StubRobot, stub_station

VERBS = verbs(ARCHO, FORMS)
POSE = Go(
    GoalKind(
        id="pose",
        title="Go to pose",
        action="go_to",
        type="x/action/GoTo",
        form={"target.x": FormField(label="x", unit="m", low=-5, high=5)},
    ),
    (
        TypedField("target.x", "double", 0.0),
        TypedField("speeds", "sequence<uint8>", []),
        TypedField("careful", "boolean", False),
        TypedField("note", "string<8>", ""),
    ),
)


def values(verb: str, *words: str) -> tuple[Any, bool]:
    """What the words mean, and whether they answer."""
    return parse(VERBS[verb], words)


def test_behind_two_dashes_nothing_is_an_option() -> None:
    node = {"node": "camera", "name": "label"}
    assert values("set", "camera", "label", "--", "--flag") == ({**node, "value": "--flag"}, False)
    assert values("set", "camera", "label", "--", "--") == ({**node, "value": "--"}, False)
    named = {"node": "", "name": "label"}
    assert values("set", "label", "--", "--flag") == ({**named, "value": "--flag"}, False)
    assert values("load", "--yes", "--", "--yes") == ({"file": "--yes"}, True)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("set max_speed", "needs [NODE] NAME VALUE"),
        ("get", "needs [NODE] NAME"),
        ("get motor_controller max_speed 1", "takes only [NODE] NAME"),
        ("save", "needs FILE"),
        ("load --yes", "needs FILE"),
        ("save a b", "takes only FILE"),
        ("halt", "needs NODE"),
        ("shelve", "needs ALARM [REASON]"),
        ("events 1 2", "takes only [N]"),
        ("cancel everything", "takes only [--all]"),
        ("call", "needs SERVICE [FIELD=VALUE ...]"),
        ("status now", "takes no values"),
        ("stop --yes", "takes no values"),
        ("release --yes now", "takes no values"),
        ("go 12 1x", "Shelf: not a whole number: 1x"),
        ("go 0", "Shelf: at least 1, not 0"),
        ("go room=1", "expected shelf=..., not room=1"),
        ("go shelf=1 shelf=2", "expected shelf=..., not shelf=2"),
    ],
)
def test_what_a_verb_does_not_take_is_one_line(line: str, said: str) -> None:
    verb, *words = line.split()
    with pytest.raises(ValueError, match=r"^[^\n]*$") as raised:
        values(verb, *words)
    assert str(raised.value) == said


@pytest.mark.parametrize(
    ("line", "meant"),
    [
        ("set n p a  b", {"node": "n", "name": "p", "value": "a b"}),
        ("set n p --yes", {"node": "n", "name": "p", "value": "--yes"}),
        ("shelve low", {"alarm": "low"}),
        ("shelve low in the workshop", {"alarm": "low", "reason": "in the workshop"}),
        ("ack", {}),
        ("events 5", {"n": "5"}),
        ("cancel --all", {"--all": True}),
        ("call add a=1 b=2", {"service": "add", "field=value": ["a=1", "b=2"]}),
        ("go 12 7", {GOALS: [{"shelf_number": 12}, {"shelf_number": 7}]}),
        ("go SHELF=7", {GOALS: [{"shelf_number": 7}]}),
        ("go shelf_number=7", {GOALS: [{"shelf_number": 7}]}),
    ],
)
def test_words_are_values_by_name(line: str, meant: dict[str, Any]) -> None:
    verb, *words = line.split()
    assert values(verb, *words) == (meant, False)


@pytest.mark.parametrize("words", ["--yes a.yaml", "a.yaml --yes", "--yes a.yaml --yes"])
def test_yes_answers_from_any_place(words: str) -> None:
    assert values("save", *words.split()) == ({"file": "a.yaml"}, True)


def test_the_verb_that_was_meant_is_named() -> None:
    with pytest.raises(ValueError, match=r"no command 'relaese' \(nearest: release\)"):
        named(VERBS, "relaese")


def test_a_goal_of_several_fields_is_typed_by_label_or_path() -> None:
    words = ["X=1.5", "speeds=[1, 2]", "careful=true", "note=a b"]
    meant = {"target.x": 1.5, "speeds": [1, 2], "careful": True, "note": "a b"}
    assert POSE.values(words) == {GOALS: [meant]}
    assert POSE.values(["target.x=1.5", *words[1:]]) == {GOALS: [meant]}


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("x=9", "x: at most 5, not 9"),
        ("speeds=[1, 300]", "speeds[1]: 300 is not within 0 .. 255"),
        ("careful=perhaps", "careful: not true or false: perhaps"),
        ("note=far too long", 'note: "far too long" has 12 characters, at most 8'),
    ],
)
def test_a_value_that_does_not_fit_its_field_is_said(word: str, said: str) -> None:
    fitting = {"x": "x=1", "speeds": "speeds=[]", "careful": "careful=no", "note": "note="}
    words = fitting | {word.partition("=")[0]: word}
    with pytest.raises(ValueError, match=r"^[^\n]*$") as raised:
        POSE.values([*words.values()])
    assert str(raised.value).startswith(said)


@pytest.mark.parametrize("verb", ["go", "send_goal"])
async def test_a_shelf_beyond_what_the_robot_holds_now_is_misuse(verb: str) -> None:
    snapshot = board(40)._replace(actions={"/move_to_shelf": (SHELF.type,)})
    robot = StubRobot(snapshot)
    station = stub_station(robot)
    words = ["/move_to_shelf"] if verb == "send_goal" else []

    async def prepared(shelf: str) -> None:
        given, _ = parse(VERBS[verb], [*words, f"shelf={shelf}"])
        await VERBS[verb].prepare(station, given)

    await prepared("40")
    with pytest.raises(ValueError, match="Shelf: at most 40, not 41"):
        await prepared("41")
    robot.snapshot = NORMAL._replace(actions=snapshot.actions)  # does not say how many
    await prepared("41")


async def test_a_goal_waits_for_the_limits_that_the_robot_has_not_reported_yet() -> None:
    known = NORMAL._replace(offered=NORMAL.offered | {"move_to_shelf"})
    others = tuple(p for p in known.parameters if p.node != "/motor_controller")
    assert others
    robot, clock = StubRobot(known._replace(parameters=())), StandingClock()
    station, go = stub_station(robot, clock), VERBS["go"]
    waits = asyncio.ensure_future(prepare_when_found(station, go, {GOALS: [{"shelf_number": 41}]}))
    await asyncio.sleep(0)
    assert not waits.done()
    waits.cancel()
    robot.snapshot = known._replace(nodes=known.nodes[:1], parameters=others)
    assert not go.is_found(station, {})  # who holds it is not found yet
    clock.passed = 5.0
    assert await prepare_when_found(station, go, {GOALS: [{"shelf_number": 41}]})
    robot.snapshot, clock.passed = board(40)._replace(offered=known.offered), 0.0
    assert go.is_found(station, {})


async def test_what_is_refused_is_tried_again_until_the_robot_is_found() -> None:
    robot, clock = StubRobot(Snapshot(file=ARCHO)), VirtualSleep()
    station = stub_station(robot, clock)
    get, speed = VERBS["get"], {"node": "motor_controller", "name": "max_speed"}
    clock.at(1.0, lambda: setattr(robot, "snapshot", NORMAL))
    prepared = await prepare_when_found(station, get, speed)
    assert not isinstance(prepared, Outcome)
    assert prepared["parameter"].value == 0.5
    assert clock.passed == pytest.approx(1.0, abs=0.1)
    with pytest.raises(ArchoError, match="no parameter nosuch"):
        await prepare_when_found(station, get, {**speed, "name": "nosuch"})
    assert clock.passed <= 2.2  # What no node has by then is not expected any more.


class VirtualSleep(StandingClock):
    """A clock that moves when somebody sleeps."""

    def __init__(self) -> None:
        super().__init__()
        self._due = (float("inf"), lambda: None)

    def at(self, passed: float, do: Callable[[], None]) -> None:
        self._due = passed, do

    async def sleep(self, seconds: float) -> None:
        self.passed += seconds
        if self.passed >= self._due[0]:
            self._due[1]()
