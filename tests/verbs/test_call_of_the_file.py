"""`call` on a service of the robot file is the verb that calls it: its question, its refusal."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest

from archo_tui.console.socket import _stop_in
from archo_tui.robot.stop.gate import Stops
from archo_tui.robot.stop.words import shell_words
from archo_tui.robot_file.model import CommandService, StopServices
from archo_tui.verbs import verbs
from archo_tui.verbs.services import choose_verb
from tests.support.archo import ARCHO, FORMS
from tests.support.console import LONG, console
from tests.support.plain import operated
from tests.support.script import Script
from tests.support.shells import guest, heard, served, typed
from tests.support.states import STATES
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


@pytest.mark.pure
@pytest.mark.parametrize(
    ("line", "verb"),
    [
        ("call reset_encoder", "reset"),
        ("call reset_encoder --yes", "reset --yes"),
        ("call reset_encoder x=1", "/reset_encoder takes no field, not x=1"),
        ("call release_emergency_stop --yes", "release --yes"),
        ("call emergency_stop whatever=1", "stop"),
        ("call set_charging data=true", "charge"),
        ('call /set_charging {"data":true}', "charge"),
        ("call set_charging", "/set_charging needs data=true (charge) or data=false (discharge)"),
        ("call set_charging data=5", "data: not true or false: 5"),
        ("call set_charging data=true more=1", "/set_charging: expected data=..., not more=1"),
        ("call emergency_stop --help", "call emergency_stop --help"),
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


@pytest.mark.pure
def test_a_name_means_this_robot_unless_it_says_another() -> None:
    services = {f"{place}/reset_encoder": ("std_srvs/srv/Trigger",) for place in ("", "/north")}
    for name in ("reset_encoder", "north/reset_encoder", "/north/reset_encoder"):
        assert chosen(f"call {name}", "/north", services=services) == "reset"
    another = "call /reset_encoder"
    assert chosen(another, "/north", services=services) == another


LATCH = StopServices("emergency_stop")
E_STOP = StopServices("e_stop", {"e_stop_on": True}, "e_stop", {"e_stop_on": False})


E_STOP_NEEDS = "/e_stop needs e_stop_on=true (stop) or e_stop_on=false (release)"
ONLY_STOPS = StopServices("e_stop", {"data": True})
TWIN = CommandService(id="zero", title="Zero", service="/reset_encoder")


@pytest.mark.pure
@pytest.mark.parametrize(
    ("line", "stop", "verb"),
    [
        ("call e_stop e_stop_on=true", E_STOP, "stop"),
        ('call /e_stop {"e_stop_on":true}', E_STOP, "stop"),
        ("call e_stop e_stop_on=false", E_STOP, "release"),
        ("call e_stop --yes e_stop_on=no", E_STOP, "release --yes"),
        ("call e_stop", E_STOP, E_STOP_NEEDS),
        ("call e_stop e_stop_on=maybe", E_STOP, "e_stop_on: not true or false: maybe"),
        ("call e_stop on=true", E_STOP, "/e_stop: expected e_stop_on=..., not on=true"),
        (
            *("call e_stop e_stop_on=false e_stop_on=true", E_STOP),
            "/e_stop: expected e_stop_on=..., not e_stop_on=true",
        ),
        ("call e_stop data=true", ONLY_STOPS, "stop"),
        ("call e_stop data=false", ONLY_STOPS, "/e_stop needs data=true (stop)"),
        ("call reset_encoder", LATCH, "/reset_encoder is called by several: type reset or zero"),
    ],
)
def test_the_request_says_which_of_several_verbs_is_meant(
    line: str, stop: StopServices, verb: str
) -> None:
    commands = (*ARCHO.commands, TWIN)
    assert chosen(line, file=replace(ARCHO, stop=stop, commands=commands)) == verb


async def test_a_release_asks_and_what_it_answers_is_told() -> None:
    async with operated() as person:
        await person.enter("stop", "STOP: confirmed")
        await person.enter("call release_emergency_stop", "failed: call: Release the stop?")
        await person.until("(add --yes to do it)")
        assert "release stop:" not in person.said
        assert await person.end("call release_emergency_stop --yes\n") == 1
        assert "YOU console: release stop: Released; nothing resumes by itself" in person.said


CALLS = [  # Words, the STOP of the file, and whether they are one.
    ("call emergency_stop", LATCH, True),
    ("call north/emergency_stop x=1", LATCH, True),
    ("call --yes emergency_stop", LATCH, True),
    ("call /emergency_stop", LATCH, False),  # another robot's, perhaps
    ("call emergency_stop --help", LATCH, False),
    ("call", LATCH, False),
    ("params emergency_stop", LATCH, False),
    ("call e_stop e_stop_on=true", E_STOP, True),
    ("call north/e_stop e_stop_on=yes", E_STOP, True),
    ("call e_stop e_stop_on=false", E_STOP, False),
    ("call e_stop", E_STOP, False),
    ("call e_stop --help", E_STOP, False),
    ("call e_stop e_stop_on=", E_STOP, False),
]


def read_as_stop(words: list[str], stop: StopServices) -> set[bool]:
    """Which of the three that read lines take these words for a STOP."""
    stops = Stops()
    stops.set_service(stop, f"/north/{stop.service}")
    line = json.dumps({"id": 1, "words": words})
    escaped = line.replace("call", "c\\u0061ll").replace("emergency", "\\u0065mergency")
    return {
        stops.is_stop_call(shell_words(" ".join(words).encode())),
        *(_stop_in(text.encode(), stops) is not None for text in (line, escaped)),
    }


@pytest.mark.pure
@pytest.mark.parametrize(("words", "stop", "is_stop"), CALLS)
def test_a_call_of_the_stop_is_a_stop_where_lines_are_read(
    words: str, stop: StopServices, is_stop: bool
) -> None:
    assert read_as_stop(words.split(), stop) == {is_stop}


@pytest.mark.pure
@pytest.mark.parametrize("service", ["emergency_stop", "/emergency_stop", "halt/now"])
@pytest.mark.parametrize("namespace", ["/", "/north"])
def test_every_name_that_means_the_stop_is_known_as_it_is_read(
    service: str, namespace: str
) -> None:
    stop = replace(LATCH, service=service)
    file = replace(ARCHO, stop=stop)
    stops = Stops()
    stops.set_service(stop, STATES["normal"]._replace(namespace=namespace).full(service))
    parts = ("", "/", "north/", "/north/")
    for name in [f"{before}{service.lstrip('/')}" for before in parts]:
        is_stop = chosen(f"call {name}", namespace, file) == "stop"
        assert stops.is_stop_call(["call", name]) or not is_stop, name


@pytest.mark.posix
def test_it_voids_what_was_typed_before_it() -> None:
    script = Script()
    assert script.end("go 3\ngo 12\ncall 'emergency_stop' --yes\n") == 1
    assert "failed: go: not sent: STOP came after it" in script.said
    assert "YOU console: STOP: confirmed" in script.said


@pytest.mark.real_time
async def test_from_a_shell_it_overtakes_what_waits_and_the_others_are_asked_about() -> None:
    async with served(ros_args=LONG) as person, guest() as client:
        person.type("go 12\n")
        await heard(person, "MOVING to 12")
        helped = await typed("call", "emergency_stop", "--help")
        assert (helped.code, helped.out.partition("\n")[0]) == (
            0,
            "call SERVICE [FIELD=VALUE ...]: Call any service on the graph",
        )
        assert "STOP" not in person.said
        asked = await typed("call", "/reset_encoder")
        assert (asked.code, "add --yes to do it" in asked.err) == (2, True)
        done = await typed("call", "reset_encoder", "--yes")
        assert (done.code, done.err) == (0, "Encoder reset to zero\n")
        client.send({"id": 1, "words": ["wait", "arrived"]})
        client.send({"id": 2, "words": ["call", "emergency_stop"]})
        ended: dict[int, str] = {}
        while len(ended) < 2:
            line = await client.line()
            if "code" in line:
                ended[line["id"]] = line["code"]
        assert ended == {1: "aborted", 2: "done"}  # behind what waits it would find it arrived


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
