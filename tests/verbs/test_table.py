"""Every verb by key and in `--plain`: its refusals, questions and words, places among them."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml

from archo_tui.base.clock import Clock
from archo_tui.base.errors import ArchoError
from archo_tui.base.paths import config_file
from archo_tui.console.plain import help_text
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.messages.types import TypedField
from archo_tui.robot.outcome import WATCHING, Outcome
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Hosted, OpenStop, Snapshot
from archo_tui.robot_file import load
from archo_tui.robot_file.model import FormField, GoalKind
from archo_tui.screen.app import ArchoApp
from archo_tui.screen.commands import registry
from archo_tui.screen.commands.base import Command, VerbCommand
from archo_tui.station.places import Places
from archo_tui.station.station import Station
from archo_tui.verbs import verbs
from archo_tui.verbs.goals import GOALS, Go
from archo_tui.verbs.nodes import DuplicateNode
from archo_tui.verbs.places import pose_goal
from archo_tui.verbs.verb import NotPossible, parse, prepare_when_found
from tests.support import clock
from tests.support.archo import ARCHO, FORMS, SHELF
from tests.support.clock import NOW
from tests.support.console import FAST, LONG, console
from tests.support.night import corners
from tests.support.plain import operated, plain, typing
from tests.support.quiet import until
from tests.support.states import NORMAL, STATES, board, goal
from tests.support.stub import StandingClock, StubRobot, Willing, stub_app, stub_station

VERBS = verbs(ARCHO, FORMS)
COMMANDS = registry(ARCHO, VERBS)
ANOTHERS = goal(Phase.MOVING, mine=False)
MOTOR = Hosted("/motor_controller", serves=("/move_to_shelf", "/emergency_stop"))
# What is refused or asked first in each, beside what ALWAYS is.
ALWAYS = {
    "continue": "no queue is held",
    "skip": "no goal waits in the queue",
    "undo": "nothing to undo",
    "release": "the robot is not stopped",
    "give_up_stop": "no STOP is waiting to be confirmed",
}
RELEASE = "Release the stop? Moves are allowed again; nothing resumes by itself."
SEND_NO_MORE = "The robot has not confirmed the STOP and may be driving. Send it no more?"
SITUATIONS: dict[str, tuple[Snapshot, dict[str, str]]] = {
    "normal": (NORMAL, {}),
    "nothing offered": (
        STATES["nothing offered"],
        {
            "release": "release_emergency_stop is not offered by any node",
            "reset": "reset_encoder is not offered by any node",
            "charge": "set_charging is not offered by any node",
            "discharge": "set_charging is not offered by any node",
        },
    ),
    "stopped": (STATES["motor stopped"], {"release": RELEASE}),
    "moving": (
        goal(Phase.MOVING),
        {"reset": "The robot is on its way to shelf 12. Reset encoder now?"},
    ),
    "another client's goal": (
        ANOTHERS,
        {
            "cancel": "Another client sent this goal. Cancel it?",
            "reset": "The robot is carrying out another client's goal. Reset encoder now?",
        },
    ),
    "STOP not confirmed": (
        NORMAL._replace(open_stop=OpenStop(NOW - 2.0)),
        {"release": RELEASE, "give_up_stop": SEND_NO_MORE},
    ),
}
# what is typed behind a verb that takes values
WORDS = {
    "go": "12", "set": "motor_controller max_speed 0.5", "get": "motor_controller max_speed",
    "start": "motor_controller", "halt": "motor_controller",
    "save": "/dev/null/x", "load": "/dev/null/x", "shelve": "stopped", "ack": "",
    "send_goal": "/move_to_shelf shelf_number=1", "call": "/reset_encoder",
    "pub": "/battery_drain", "go_list": "round", "save_place": "here 1", "save_queue": "round",
    "log_level": "motor_controller debug",
    "lifecycle": "motor_controller activate",
    "echo": "/battery_level", "hz": "/battery_level",
    "interface": "archo_interfaces/msg/MotorStatus",
    "forget": "motor", "tf": "",
}  # fmt: skip


def test_every_verb_is_spoken_by_a_command_and_each_command_speaks_verbs_that_exist() -> None:
    spoken = {verb for command in COMMANDS for verb in command.verbs}
    # A shelf is not where the robot is, and who looks at the screen waits without a verb.
    assert spoken | {"places", "save_place", "wait"} == set(VERBS)


def test_every_verb_is_listed_by_help_with_what_it_takes() -> None:
    lines = help_text(VERBS).splitlines()
    for verb in VERBS.values():
        (line,) = [line for line in lines if line.split()[0].rstrip(":") == verb.id]
        assert verb.usage in line
        assert line.endswith(verb.help)


async def by_key(snapshot: Snapshot, watching: bool) -> dict[str, str]:
    """Why each verb of a command cannot run, else what it asks, else nothing."""
    app = stub_app(snapshot, hosted=(MOTOR,))
    app.station.robot = Willing(snapshot, watching=watching)  # type: ignore[assignment]
    app.station.refresh()
    found: dict[str, str] = {}
    async with app.run_test(size=(120, 36)):
        asked: list[str] = []
        app.confirm = lambda _, text, *__: asked.append(text)  # type: ignore[method-assign]
        for command in COMMANDS:
            for verb in {*command.verbs} - WORDS.keys() - {"stop"}:  # STOP is always tried.
                asked.clear()
                found[verb] = _answer(app, command, verb) or "".join(asked)
    return found


def _answer(app: ArchoApp, command: Command, verb: str) -> str:
    """Run a command; return why it cannot run."""
    if not isinstance(command, VerbCommand):
        return VERBS[verb].refusal(app.station)
    reason = command.disabled_reason(app)
    if not reason and (work := app.run_verb(VERBS[verb], {})) is not None:
        work.close()
    return reason


async def failures(station: Station, verbs: Iterable[str]) -> dict[str, str]:
    """Why each line was not carried out, as it is said."""
    lines = "".join(f"{verb} {WORDS.get(verb, '')}\n" for verb in verbs)
    async with typing(station) as person:
        await person.enter(f"{lines}help", "List these")
        said = [line.partition(" failed: ")[2] for line in person.said.splitlines()]
    return dict(line.split(": ", 1) for line in said if line)


@pytest.mark.parametrize(
    ("situation", "watching"),
    corners(
        [*((situation, False) for situation in SITUATIONS), ("moving", True)],
        [(situation, True) for situation in SITUATIONS],
    ),
)
async def test_a_key_and_a_line_are_refused_and_asked_alike(situation: str, watching: bool) -> None:
    snapshot, differing = SITUATIONS[situation]
    keys = await by_key(snapshot, watching)
    robot = Willing(snapshot, watching=watching)
    lines = await failures(stub_station(robot, clock.current or Clock(), (MOTOR,)), keys)
    wanted = ALWAYS | differing
    if watching:
        wanted = {verb: WATCHING for verb in keys if VERBS[verb].acts}
    assert {verb: why for verb, why in keys.items() if why} == wanted
    said = {verb: why.removesuffix(" (add --yes to do it)") for verb, why in lines.items()}
    assert said == wanted


async def test_whoever_only_watches_does_nothing() -> None:
    station = stub_station(Willing(NORMAL, watching=True), clock.current or Clock(), (MOTOR,))
    acting = [name for name, verb in VERBS.items() if verb.acts and name != "stop"]
    # A STOP is refused by the robot's own client.
    assert await failures(station, acting) == dict.fromkeys(acting, WATCHING)


async def test_a_node_is_asked_for_alike_by_key_and_line() -> None:
    station = stub_station(Willing(goal(Phase.MOVING)), clock.current or Clock(), (MOTOR,))
    async with typing(station) as person:
        person.type("halt motor_controller\nhalt motor_contoller\nhelp\n")
        await person.until("List these")
    assert (
        "failed: halt: The robot is on its way to shelf 12, and /motor_controller serves "
        "move_to_shelf and emergency_stop. Stop the node? (add --yes to do it)"
    ) in person.said
    copied = DuplicateNode().question(station, {"node": MOTOR.name})
    assert copied is not None
    assert "a call reaches both, and both act. STOP must then be confirmed" in copied.text
    assert "motor_contoller does not run in this process (nearest: motor_controller)" in person.said


def test_each_way_of_a_toggle_says_what_it_does() -> None:
    unnamed = replace(ARCHO.commands[0], id="light", title="Light", off="")
    made = verbs(replace(ARCHO, commands=(*ARCHO.commands, unnamed)), FORMS)
    assert made["discharge"].help_line == "discharge: Stop charging"
    assert made["light_off"].help_line == "light_off: Switch light off"


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
        ("get motor_controller max_speed 1", "takes only [NODE] NAME"),
        ("load --yes", "needs FILE"),
        ("shelve", "needs ALARM [REASON]"),
        ("cancel everything", "takes only [--all]"),
        ("call", "needs SERVICE [FIELD=VALUE ...]"),
        ("status now", "takes no values"),
        ("go 12 1x", "Shelf: not a whole number: 1x"),
        ("go 0", "Shelf: at least 1, not 0"),
        ("go room=1", "expected shelf=..., not room=1"),
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
        ("events 5", {"n": "5"}),
        ("cancel --all", {"--all": True}),
        ("call add a=1 b=2", {"service": "add", "field=value": ["a=1", "b=2"]}),
        ("go 12 7", {GOALS: [{"shelf_number": 12}, {"shelf_number": 7}]}),
        ("go shelf_number=7", {GOALS: [{"shelf_number": 7}]}),
    ],
)
def test_words_are_values_by_name(line: str, meant: dict[str, Any]) -> None:
    verb, *words = line.split()
    assert values(verb, *words) == (meant, False)


@pytest.mark.parametrize("words", ["--yes a.yaml", "a.yaml --yes", "--yes a.yaml --yes"])
def test_yes_answers_from_any_place(words: str) -> None:
    assert values("save", *words.split()) == ({"file": "a.yaml"}, True)


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


PLACES = """
places:
  - {name: dock, values: {shelf_number: 1}}
  - {name: far, values: {shelf_number: 99}}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """ARCHO's robot file with two places."""
    path = tmp_path / "robot.yaml"
    path.write_text(load.default_path().read_text(encoding="utf-8") + PLACES)
    return path


async def test_a_place_is_a_goal_and_no_other_word_is(file: Path) -> None:
    code, said = await plain("go dock 2\ngo dok\ngo far\ngo 3 nan\n", robot=file, ros_args=FAST)
    assert code == 1
    assert "goal ARRIVED, Arrived at shelf 1" in said
    assert "goal ARRIVED, Arrived at shelf 2" in said
    assert "failed: go: no place dok (nearest: dock)" in said
    assert "failed: go: Shelf: at most 40, not 99" in said
    assert "failed: go: Shelf: not a whole number: nan" in said  # nan is the name of no place
    assert "shelf 3" not in said
    code, said = await plain("go dock\n", ros_args=FAST)  # A robot without places.
    assert (code, "failed: go: Shelf: not a whole number: dock" in said) == (1, True)


async def test_what_is_saved_under_a_name_is_there_for_the_next_console(file: Path) -> None:
    config_file("places.yaml").unlink(missing_ok=True)
    lines = "save_place mine 7\nsave_place dock 3\nsave_place 5 3\nsave_place two 1 2\nplaces\n"
    _, said = await plain(lines, robot=file, ros_args=FAST)
    assert "YOU console: place mine: saved as 7" in said
    assert "failed: save_place: dock is a place of the robot file" in said
    assert "failed: save_place: '5' is no name" in said
    assert "failed: save_place: a place is one goal" in said
    assert "dock: shelf 1\nfar: shelf 99\nmine: shelf 7\n" in said
    async with operated(robot=file, ros_args=FAST) as person:
        await person.enter("go mine", "Arrived at shelf 7")
        path = config_file("places.yaml")
        path.write_text(path.read_text().replace("shelf_number: 7", "shelf_number: 5"))
        await person.enter("go mine", "Arrived at shelf 5")  # The file's, changed meanwhile.


async def test_a_queue_that_was_saved_is_driven_again_and_held_by_a_stop(file: Path) -> None:
    config_file("places.yaml").unlink(missing_ok=True)
    async with operated(robot=file, ros_args=LONG) as person:
        station = person.station
        person.type("go 12 7 3\nsave_queue round\nskip\nskip\n")
        await until(lambda: "round" in station.places.lists and not station.queue.waiting)
        await person.enter("stop", "STOP: confirmed")
        await person.enter("release --yes", "release stop: ")
        person.type("go_list round 2\n")
        await until(lambda: len(station.queue.waiting) == 5)
        assert [goal.text for goal in station.queue.waiting] == ["7", "3", "12", "7", "3"]
        person.type("stop\n")
        await until(lambda: station.queue.hold_reason == "STOP")
        person.type("release --yes\nplaces\n")
        await person.until("round: a list of 3 goals")
        await until(lambda: not station.robot.snapshot.is_stopped)
        assert station.running_goal is None
        assert len(station.queue.waiting) == 5  # It never goes on by itself.
        person.type("go_list round 0\ngo_list rund\ngo_list round 1000\n")
        await person.until("failed: go_list: how often: from 1 to 1000, not 0")
        await person.until("failed: go_list: no list rund (nearest: round)")
        await person.until("failed: go_list: more than 1000 goals would wait")


async def test_places_stand_in_the_palette(file: Path) -> None:
    async with console(*FAST, robot=file) as op:
        await op.press("ctrl+p")
        await op.type("dock")
        await op.until("Go to dock")
        await op.press("enter")
        await op.until("Arrived at shelf 1")


@pytest.mark.parametrize(
    "text",
    [
        "- 1",
        "ARCHO: {places: {dock: {goal: shelf}}}",
        "ARCHO: {places: {dock: {goal: shelf, values: {shelf: 3}}}}",
        "ARCHO: {places: {dock: {goal: nothere, values: abc}}}",
        "ARCHO: {places: {'1': {goal: shelf, values: {shelf_number: 1}}}}",
        "ARCHO: [",
    ],
)
def test_a_file_that_is_none_is_said_and_never_written_over(text: str, tmp_path: Path) -> None:
    path = tmp_path / "places.yaml"
    path.write_text(text)
    places = Places(ARCHO, path)
    places.load()
    assert str(path) in places.fault
    assert places.all == []
    with pytest.raises(ArchoError):
        places.save_place("dock", SHELF, {"shelf_number": 1})
    assert path.read_text() == text


def test_two_consoles_and_two_robots_keep_each_others_places(tmp_path: Path) -> None:
    path = tmp_path / "places.yaml"
    others = {"places": {"home": {"goal": "x", "values": {"y": 1}}}, "of_a_later_version": ["z"]}
    path.write_text(f"other: {json.dumps(others)}\n")
    one, two = Places(ARCHO, path), Places(ARCHO, path)
    one.save_place("a", SHELF, {"shelf_number": 1})
    two.save_list("b", [QueuedGoal(SHELF, {"shelf_number": 2})])
    three = Places(ARCHO, path)
    three.load()
    assert three.of(SHELF) == {"a": {"shelf_number": 1}}
    assert [goal.values for goal in three.goals("b")] == [{"shelf_number": 2}]
    assert yaml.safe_load(path.read_text())["other"] == others


def test_the_palette_saves_the_pose_only_for_a_goal_that_is_one() -> None:
    pose = replace(SHELF, id="pose", form={"x": FormField(), "pose.y": FormField()})
    for goals, offered in (((SHELF,), False), ((SHELF, pose), True), ((), False)):
        commands = registry(replace(ARCHO, goals=goals))
        assert any("save_place" in command.verbs for command in commands) is offered
    with pytest.raises(NotPossible, match="Shelf is no part of a pose"):
        pose_goal(SHELF, {"x": 1.0, "y": 2.0, "yaw": 0.0})


def test_a_place_that_could_not_be_written_is_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    places = Places(ARCHO, tmp_path / "places.yaml")
    places.save_place("a", SHELF, {"shelf_number": 1})

    def refuse(*_: object) -> None:
        raise ArchoError("the disk is full")

    monkeypatch.setattr("archo_tui.station.places.write_atomically", refuse)
    with pytest.raises(ArchoError, match="the disk is full"):
        places.save_place("a", SHELF, {"shelf_number": 7})
    assert places.find(SHELF, "a") == {"shelf_number": 1}


def test_an_own_place_gives_way_to_one_of_the_robot_file(file: Path, tmp_path: Path) -> None:
    path = tmp_path / "places.yaml"
    path.write_text("")
    places = Places(load.load(file), path)
    places.load()
    assert places.fault == ""
    own = "ARCHO: {places: {dock: {goal: shelf, values: {shelf_number: 9}}, "
    path.write_text(f"{own}x: {{goal: shelf, values: {{shelf_number: 2}}}}}}}}")
    places.load()
    assert places.fault == ""
    assert places.find(SHELF, "dock") == {"shelf_number": 1}
    assert places.find(SHELF, "x") == {"shelf_number": 2}
