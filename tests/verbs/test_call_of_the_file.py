"""`call` on a service of the robot file is the verb that calls it: its question, its refusal."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from archo_tui.robot.stops import Stops
from archo_tui.robot_file.model import Service
from archo_tui.verbs import verbs
from archo_tui.verbs.called import choose_verb
from tests.console.states import STATES
from tests.support.archo import ARCHO, FORMS
from tests.support.console import LONG, console
from tests.support.plain import operated
from tests.support.script import Script
from tests.support.shells import heard, raw, served, typed
from tests.support.stub import StubRobot, stub_station


def chosen(line: str, namespace: str = "/", file: Any = ARCHO, **graph: Any) -> str:
    """The verb that a line means and its words, or why it means none."""
    snapshot = STATES["motor stopped"]._replace(namespace=namespace, file=file, **graph)
    robot: Any = StubRobot(snapshot)
    word, *words = line.split()
    try:
        verb, rest = choose_verb(verbs(file, FORMS), stub_station(robot), word, words)
    except ValueError as error:
        return str(error)
    return " ".join((verb.id, *rest))


@pytest.mark.parametrize(
    ("line", "verb"),
    [
        ("call reset_encoder", "reset"),
        ("call /reset_encoder {}", "reset"),
        ("call reset_encoder --yes", "reset --yes"),
        ("call --yes reset_encoder", "reset --yes"),
        ("call reset_encoder x=1", "/reset_encoder takes no field, not x=1"),
        ("call release_emergency_stop --yes", "release --yes"),
        ("call emergency_stop whatever=1", "stop"),
        ("call set_charging data=true", "charge"),
        ("call set_charging data=no", "discharge"),
        ('call /set_charging {"data":true}', "charge"),
        ("call set_charging", "/set_charging needs data=true (charge) or data=false (discharge)"),
        ("call set_charging data=5", "data: not true or false: 5"),
        ("call set_charging data=true more=1", "/set_charging takes data=..., not more"),
        ("call other x=1", "call other x=1"),
        (
            "call /move_to_shelf/_action/send_goal goal.shelf_number=99",
            "/move_to_shelf/_action/send_goal is a part of the action /move_to_shelf: type go",
        ),
        (
            "call spin/_action/cancel_goal",
            "/spin/_action/cancel_goal is a part of the action /spin: type cancel",
        ),
        (
            "call spin/_action/send_goal",
            "/spin/_action/send_goal is a part of the action /spin: type send_goal /spin",
        ),
    ],
)
def test_it_is_the_verb_that_the_file_names(line: str, verb: str) -> None:
    assert chosen(line) == verb


@pytest.mark.parametrize(
    ("name", "verb"),
    [
        ("reset_encoder", "reset"),
        ("north/reset_encoder", "reset"),
        ("/north/reset_encoder", "reset"),
        ("/reset_encoder", "call /reset_encoder"),  # another robot's
    ],
)
def test_a_name_means_this_robot_unless_it_says_another(name: str, verb: str) -> None:
    services = {f"{place}/reset_encoder": ("std_srvs/srv/Trigger",) for place in ("", "/north")}
    assert chosen(f"call {name}", "/north", services=services) == verb


def test_two_commands_on_one_service_are_asked_which() -> None:
    twin = Service(id="zero", title="Zero", service="/reset_encoder")
    file = replace(ARCHO, commands=(*ARCHO.commands, twin))
    said = chosen("call reset_encoder", file=file)
    assert said == "/reset_encoder is called by several: type reset or zero"


async def test_a_release_asks_and_what_it_answers_is_told() -> None:
    async with operated() as person:
        person.type("stop\n")
        await person.until("STOP: confirmed")
        person.type("call release_emergency_stop\n")
        await person.until("failed: call: Release the stop?")
        await person.until("(add --yes to do it)")
        assert "release stop:" not in person.said
        assert await person.end("call release_emergency_stop --yes\n") == 1
        assert "YOU console: release stop: Released; nothing resumes by itself" in person.said


def test_a_call_of_the_stop_is_one_where_lines_are_read() -> None:
    stops = Stops()
    stops.known_as("emergency_stop", "/north/emergency_stop")
    names = "emergency_stop", "north/emergency_stop", "/north/emergency_stop"
    assert all(stops.is_call(["call", name, "x=1"]) for name in names)
    others = ["call", "/emergency_stop"], ["call"], ["params", "emergency_stop"], ["call", "stop"]
    assert not any(stops.is_call(words) for words in others)


@pytest.mark.posix
def test_it_voids_what_was_typed_before_it() -> None:
    script = Script()
    assert script.end("go 3\ngo 12\ncall 'emergency_stop' --yes\n") == 1
    assert "failed: go: not sent: STOP came after it" in script.said
    assert "YOU console: STOP: confirmed" in script.said


@pytest.mark.real_time
async def test_from_a_shell_it_overtakes_what_waits_and_the_others_are_asked_about() -> None:
    async with served(ros_args=LONG) as person:
        person.type("go 12\n")
        await heard(person, "MOVING to 12")
        asked = await typed("call", "/reset_encoder")
        assert (asked.code, "add --yes to do it" in asked.err) == (2, True)
        done = await typed("call", "reset_encoder", "--yes")
        assert (done.code, done.err) == (0, "Encoder reset to zero\n")
        client = await raw()
        await client.line()
        client.send({"id": 1, "words": ["wait", "arrived"]})
        client.send({"id": 2, "words": ["call", "emergency_stop"]})
        first = await client.line()
        while first.get("id") not in (1, 2):
            first = await client.line()
        assert (first["id"], first["code"]) == (2, "done")
        client.close()


async def test_the_dialog_lists_what_is_done_and_asks_first() -> None:
    async with console(*LONG) as op:
        await op.press("g", *"12", "enter")
        await op.until("MOVING")
        await op.press("escape", "C", *"charg")
        assert "Charge" in op.line("/set_charging")
        assert "discharge" in op.text
        for _ in "charg":
            await op.press("backspace")
        await op.press(*"reset", "enter")
        await op.until("Reset encoder now?")
        await op.press("escape")
        await op.press("C", *"emergency_stop", "enter")
        await op.until("STOP: confirmed")
