"""Options of verbs, their help, and what is said of verbs where no console runs."""

from __future__ import annotations

import json
from typing import Any

import pytest

from archo_tui.base.errors import ArchoError
from archo_tui.cli import main
from archo_tui.cli.verb import helps, verbs_of_file
from archo_tui.client import find, shell
from tests.support.console import FAST, LONG
from tests.support.shells import Graph, guest, heard, said, served, typed
from tests.support.waiting import DEADLINE

pytestmark = pytest.mark.real_time

ENDS = [  # what is typed, the exit code, and what is said on standard error
    ("wait battery 100 --timeout 0", 4, "wait: not yet"),
    ("wait idle --timeout x", 2, "--timeout: not a time in s: x"),
    ("status --jsn", 2, "status: takes no values (nearest to --jsn: --json)"),
    ("status --to 1", 3, "no console 1 runs here"),
    ("pub cmd_vel --rate 0", 2, "pub: --rate: more than 0, at most 100 Hz, not 0\n"),
    ("wait idle", 0, "idle"),
    ("wait ready", 0, "ready"),
    ("wait battery 10", 0, "8"),  # And some tenths less on a slow machine.
    ("go 3 --follow", 2, "go has no --follow: events and echo have it"),
    ("events --once", 2, "events has no --once: echo has it"),
    ("reset --wait", 2, "reset has no --wait: it sends no goals"),
    ("wait idle --wait", 2, "wait has no --wait: it sends no goals"),
    ("events 3 --follow", 2, "only events can be followed, without further words"),
    ("chek x.py", 2, "no command 'chek' (nearest: check)\n"),
]


async def test_the_exit_code_says_how_it_ended_and_misuse_sends_nothing() -> None:
    async with served(ros_args=FAST) as person:
        for words, code, why in ENDS:
            told = await typed(*words.split())
            assert (told.code, told.out) == (code, ""), words
            assert why in told.err, words
        assert person.station.robot.snapshot.goal is None
        for verb in ("go", "cancel", "status", "echo"):  # As without a console.
            assert (await typed(verb, "--help")).out == f"{helps()[verb]}\n"


async def test_when_its_time_is_over_a_verb_cancels_what_it_sent_and_says_so() -> None:
    async with served(ros_args=LONG) as person:
        station = person.station
        told = await typed("go", "12", "7", "--wait", "--timeout", "0.5")
        assert (told.code, told.err) == (
            4,
            "accepted\narcho-tui: go: not within 0.5 s: Cancelled mid-route\n",
        )
        assert station.robot.snapshot.running_goal is None
        assert not station.queue.waiting
        assert (await typed("events", "--follow", "--timeout", "0.2")).code == 4
        assert (await typed("wait", "battery", "100", "--timeout", "0.2")).code == 4
        assert (await typed("stop", "--timeout", "0")).code == 0
        await heard(person, "STOP: confirmed")


NOBODY = "no console runs here"


@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        (
            "go 12",
            3,
            f"archo-tui: {NOBODY}: start archo-tui, or archo-tui --plain; "
            "ARCHO_TUI_SOCKETS is set: only /",
        ),
        ("release", 3, f"archo-tui: {NOBODY}"),
        ("reset", 3, f"archo-tui: {NOBODY}"),
        ("dock", 3, f"archo-tui: {NOBODY}"),  # a robot file may have it
        ("relaese", 2, f"archo-tui: no command 'relaese' (nearest: release), and {NOBODY}"),
        ("chek x.py", 2, f"archo-tui: no command 'chek' (nearest: check), and {NOBODY}"),
        ("go 12 --line", 2, "archo-tui: go has no --line: status has it"),
        ("gO --help", 2, "archo-tui: no command 'gO' (nearest: go)"),
        ("relaese --help", 2, "archo-tui: no command 'relaese' (nearest: release)"),
        ("stop", 3, f"archo-tui: STOP was not sent: {NOBODY}"),
        ("stop;", 3, f"archo-tui: STOP was not sent: {NOBODY}"),
    ],
)
def test_without_a_console_the_codes_hold(words: str, code: int, text: str) -> None:
    told = said(*words.split())
    assert (told.code, told.out) == (code, "")
    assert told.err.startswith(text)
    assert told.err.count("\n") == 1
    as_json = said(*words.split(), "--json")
    (line,) = as_json.out.splitlines()
    assert json.loads(line)["code"] == ("misuse" if code == 2 else "unreached")
    assert json.loads(line)["text"]
    assert (as_json.code, as_json.err) == (code, "")


def test_no_option_that_a_verb_has_is_taken_for_a_misspelt_one() -> None:
    for verb in verbs_of_file().values():
        for option in verb.option_names:
            result = {"code": "misuse", "text": "add --yes to do it"}
            assert "nearest" not in shell._failure_text(result, [verb.id, option], ()), verb.id


def test_without_a_console_every_verb_has_its_help() -> None:
    for verb in verbs_of_file().values():
        told = said(verb.id, "--help")
        assert (told.code, told.err) == (0, "")
        assert told.out.startswith(f"{verb.help_line}\n\noptions:\n")
        assert ("--wait" in told.out, "--yes" in told.out) == (
            verb.has_goals,
            verb.may_ask,
        ) or verb.id == "stop"


async def test_the_help_of_wait_is_its_own_with_json_too() -> None:
    async with served(ros_args=FAST):
        for words in (["wait", "--help"], ["wait", "idle", "--help"]):
            told, as_json = await typed(*words), await typed(*words, "--json")
            assert (told.code, as_json.code) == (0, 0)
            assert told.out.startswith("wait STATE [N]: Wait for a state of the robot: idle, ")
            assert json.loads(as_json.out)["text"] == told.out.rstrip("\n")


async def test_a_question_ends_with_a_no_with_its_time_and_with_whoever_was_asked() -> None:
    async with served(ros_args=FAST), guest() as client:
        await typed("stop")
        for timeout, says, code, text in (
            (DEADLINE, {"answer": False}, "cancelled", "stay stopped"),
            (0.1, {}, "ran_out", "not within 0.1 s: nobody has answered"),
            (None, {"give_up": True}, "cancelled", "stay stopped"),
        ):
            release = {"id": 1, "words": ["release"], "person": True, "timeout": timeout}
            client.send(release)
            asked = await client.line()
            assert ("Release the stop?" in asked["ask"], asked["go"]) == (True, "Release")
            if says:
                client.send(says)
            result = await client.result()
            assert (result["code"], result["text"]) == (code, text)
        assert (await client.ask("release", "--yes"))["code"] == "done"  # Nothing was released.


@pytest.mark.parametrize("wrong", ["--bogus", "--engine ros3", "--only", "--ros-args -p a:=b --"])
def test_with_json_an_option_that_is_wrong_is_one_object_too(
    wrong: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*wrong.split(), "status", "--json"]) == 2
    out, err = capsys.readouterr()
    assert (json.loads(out)["code"], err) == ("misuse", "")


def test_where_ros_is_missing_json_is_one_object_too(capsys: pytest.CaptureFixture[str]) -> None:
    def attach() -> Any:
        raise ArchoError("ROS 2 was not found")

    assert shell.run(["stop", "--json"], (), attach, {"engine": "ros2"}) == 2
    assert json.loads(capsys.readouterr().out) == {"code": "misuse", "text": "ROS 2 was not found"}


@pytest.mark.parametrize(
    ("words", "variable", "reaches"),
    [
        ("stop", "", True),
        ("stop;", "4711", True),
        ("-- stop", "", True),
        ("! stop now", "", True),
        ("stop --to 4711", "", False),
        ("cancel", "", True),
        ("cancel", "4711", False),
        ("cancel --to 4711", "", False),
        ("cancel --help", "", False),
    ],
)
def test_the_graph_is_attached_to_where_no_console_is_named(
    words: str, variable: str, reaches: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(find.CHOSEN, variable)
    graph = Graph()
    meant = {"engine": "ros2", "domain": 5}
    code = shell.run(words.split(), (), graph.attach, meant, helps)
    assert bool(graph.asked) == reaches
    if "stop" in words and reaches:
        assert graph.asked == [["stop"]]
    assert code == (0 if reaches or "--help" in words else 3)
