"""`archo-tui VERB`: what a shell says, prints and ends with, with each option."""

from __future__ import annotations

import asyncio
import errno
import io
import json
import os
import signal
import subprocess
import sys
from typing import Any
from unittest.mock import patch

import pytest

from archo_tui.base.errors import ArchoError
from archo_tui.cli import main
from archo_tui.cli.options import SUBCOMMANDS
from archo_tui.cli.verb import helps, verbs_of_file
from archo_tui.client import find, shell
from archo_tui.console import session
from tests.support.console import FAST, LONG
from tests.support.robot import hearing
from tests.support.script import SLOW, Script
from tests.support.shells import Graph, Said, client, guest, heard, said, served, typed, until
from tests.support.terminal import Terminal
from tests.support.waiting import DEADLINE

pytestmark = pytest.mark.real_time


async def ended(process: subprocess.Popen[str]) -> Said:
    """How a client in a process of its own ends."""
    out, err = await asyncio.to_thread(process.communicate, timeout=DEADLINE)
    return Said(process.returncode, out, err)


async def test_a_cancelled_goal_and_those_behind_it_end_their_waits_with_5() -> None:
    async with served(ros_args=LONG) as person:
        first = client("go", "12", "--wait")
        await heard(person, "MOVING to 12")
        second = client("go", "7", "--wait")
        await until(lambda: person.station.queue.waiting)
        assert (await typed("wait", "arrived", "--timeout", "0")).code == 4
        assert (await typed("cancel")).code == 0
        assert await ended(first) == (5, "", "accepted\narcho-tui: go: Cancelled mid-route\n")
        assert await ended(second) == (5, "", "queued\narcho-tui: go: held: 7 (cancelled)\n")
        await until(lambda: not person.station.queue.waiting)  # nobody waits for it now


async def test_a_goal_that_is_put_into_a_held_queue_ends_its_wait_with_5() -> None:
    async with served(ros_args=FAST) as person:
        station = person.station
        assert (await typed("go", "12", "7")).code == 0
        await typed("stop")
        await until(lambda: station.queue.hold_reason)
        assert (await typed("release", "--yes")).code == 0
        waits = await typed("go", "3", "5", "--wait")
        assert waits == (5, "", "accepted\narcho-tui: go: held: 5 (STOP)\n")
        await heard(person, "Arrived at shelf 3")
        await heard(person, "left out of the queue: 5 (nobody waits for it any more)")
        assert [goal.text for goal in station.queue.waiting] == ["7"]


async def test_a_goal_that_was_held_and_goes_on_is_waited_for_to_its_end() -> None:
    async with served(ros_args=("-p", "feedback_period:=0.1", "-p", "time_scale:=5.0")) as person:
        station = person.station
        waits = client("go", "12", "7", "--wait")
        await heard(person, "MOVING to 12")
        station.goals._become(station.queue._hold("an obstacle"))
        await heard(person, "queue held: 7 (an obstacle)")
        assert (await typed("continue")).code == 0
        assert (await typed("set", "motor_controller", "time_scale", "75")).code == 0
        assert await ended(waits) == (0, "", "accepted\nArrived at shelf 7\n")


async def test_data_is_on_standard_output_and_nothing_else() -> None:
    async with served(ros_args=FAST):
        line = await typed("status", "--line")
        assert (line.code, line.err) == (0, "")
        assert line.out.startswith("ARCHO 8")
        told = json.loads((await typed("status", "--json")).out)
        assert told["code"] == "done"
        assert told["data"]["battery"]["source"] == "measured"
        assert told["data"]["goal"] is None
        result = json.loads((await typed("go", "99", "--wait", "--json")).out.splitlines()[-1])
        assert result["code"] == "misuse"
        params = json.loads((await typed("params", "--json")).out)["data"]
        speed = next(p for p in params if p["name"] == "max_speed")
        assert (speed["value"], speed["high"]) == (0.8, 2.0)


class Full(io.StringIO):
    """A terminal that takes nothing more."""

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize("stderr", [None, Full()])
async def test_who_cannot_read_why_still_gets_the_exit_code(stderr: Full | None) -> None:
    def run(*words: str) -> int:
        with patch.object(sys, "stderr", stderr), patch.object(sys, "stdin", Full()):
            return shell.run(words, SUBCOMMANDS)

    async with served(ros_args=FAST) as person:
        assert await asyncio.to_thread(run, "go", "12", "--wait") == 0
        assert await asyncio.to_thread(run, "stop") == 0
        assert await asyncio.to_thread(run, "go", "99") == 2
        await heard(person, "Arrived at shelf 12")


def test_where_there_are_no_such_sockets_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr("socket.AF_UNIX")
    assert said("status") == Said(
        3, "", "archo-tui: this system has no sockets for it: only Linux and macOS do\n"
    )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_client_that_ends_takes_its_goals_along(number: int) -> None:
    with Script(*SLOW) as script:
        script.ready()
        shell = client("go", "12", "7", "--wait")
        script.until("MOVING to 12")
        shell.send_signal(number)
        _, err = shell.communicate(timeout=DEADLINE)
        script.until("CANCELLED")
        if number != signal.SIGKILL:
            assert shell.returncode == 130
            assert "Cancelled" in err
        script.type("status\n")
        assert "shelf 7" not in script.said


@pytest.mark.parametrize("again", [False, True], ids=["once", "twice"])
def test_ctrl_c_ends_within_3_s_also_when_the_console_hangs(again: bool) -> None:
    with Script(*SLOW, fresh=True) as script:  # it is suspended
        script.ready()
        shell = client("go", "12", "--wait")
        script.until("MOVING to 12")
        script.signal(signal.SIGSTOP)
        shell.send_signal(signal.SIGINT)
        if again:
            with pytest.raises(subprocess.TimeoutExpired):
                shell.wait(1.0)
            shell.send_signal(signal.SIGTERM)
        _, err = shell.communicate(timeout=4.0)
        assert "Traceback" not in err
        assert shell.returncode == (-signal.SIGTERM if again else 130)
        assert again or "the console does not answer; the robot may still be moving" in err
        script.signal(signal.SIGCONT)
        script.until("CANCELLED")


def test_what_asks_is_answered_at_the_callers_terminal(terminals: list[Terminal]) -> None:
    with Script(*SLOW) as script:
        script.type("stop\n")
        script.until("STOP: confirmed")
        for typed, code in (("\x03", 130), ("n\r", 5), ("y\r", 0)):
            terminal = Terminal("release", domain=script.domain)
            terminals.append(terminal)
            terminal.until("nothing resumes by itself. [y/N]")
            terminal.write(typed)
            assert terminal.exit_code() == code
            assert said("go", "12").code == (0 if code == 0 else 1)  # else the robot is stopped


async def test_what_a_suspended_shell_publishes_ends_with_no_speed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    geometry, speeds = pytest.importorskip("geometry_msgs.msg"), list[float]()
    driven = hearing(speeds, geometry.Twist, "cmd_vel", read=lambda message: message.linear.x)
    words = "pub", "cmd_vel", "linear.x=0.5", "--rate", "20", "--yes"
    async with served(driven) as person:
        command = [sys.executable, "-m", "archo_tui", *words]  # Suspended, so no fork of another.
        shell = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        with monkeypatch.context() as patient:  # A busy shell answers late.
            patient.setattr(session, "_MAX_MISSED_BEATS", 100)
            await until(lambda: len(speeds) > 30)  # It lasts while the shell answers.
        shell.send_signal(signal.SIGSTOP)
        await until(lambda: speeds[-1] == 0.0)
        await heard(person, "pub cmd_vel: ended by its requester")
        shell.send_signal(signal.SIGCONT)
        said = await ended(shell)
        assert (said.code, "this program gave no sign for 1 s" in said.err) == (5, True)
        assert speeds[-1] == 0.0


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
        ("dock", 3, f"archo-tui: {NOBODY}"),  # a robot file may have it
        ("relaese", 2, f"archo-tui: no command 'relaese' (nearest: release), and {NOBODY}"),
        ("go 12 --line", 2, "archo-tui: go has no --line: status has it"),
        ("gO --help", 2, "archo-tui: no command 'gO' (nearest: go)"),
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


def test_without_a_console_every_verb_has_its_help() -> None:
    for verb in verbs_of_file().values():
        told = said(verb.id, "--help")
        assert (told.code, told.err) == (0, "")
        assert told.out.startswith(f"{verb.help_line}\n\noptions:\n")
        assert ("--wait" in told.out, "--yes" in told.out) == (
            verb.has_goals,
            verb.may_ask,
        ) or verb.id == "stop"


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
