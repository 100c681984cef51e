"""Every verb is there by key or palette and in `--plain`, with the same refusals and questions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import pytest

from archo_tui.base.clock import Clock
from archo_tui.console.plain import help_text
from archo_tui.robot.outcome import WATCHING
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Hosted, OpenStop, Snapshot
from archo_tui.screen.app import ArchoApp
from archo_tui.screen.commands import registry
from archo_tui.screen.commands.base import Command, VerbCommand
from archo_tui.station.station import Station
from archo_tui.verbs import verbs
from archo_tui.verbs.nodes import DuplicateNode
from tests.support import clock
from tests.support.archo import ARCHO, FORMS
from tests.support.clock import NOW
from tests.support.night import corners
from tests.support.plain import typing
from tests.support.states import NORMAL, STATES, goal
from tests.support.stub import Willing, stub_app, stub_station

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


def test_what_a_command_says_of_itself_is_what_its_verb_does() -> None:
    for command in COMMANDS:
        if isinstance(command, VerbCommand):
            assert command.verb.id in command.verbs


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
