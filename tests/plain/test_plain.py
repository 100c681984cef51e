"""`--plain`: commands on standard input, an event a line, an exit code for scripts."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from rclpy.node import Node

from archo_tui.cli.options import console_parser
from tests.support import clock
from tests.support.console import FAST as QUICK
from tests.support.console import LONG
from tests.support.night import corners
from tests.support.plain import operated, plain
from tests.support.script import SLOW, Script, shell

ROOT = Path(__file__).parent.parent.parent


@pytest.mark.parametrize("last", ["go 12\nquit\n", "go 12"])
async def test_the_end_waits_for_the_goal_however_it_is_asked_for(last: str) -> None:
    code, said = await plain(last, ros_args=QUICK)
    assert code == 0, said
    assert "YOU console: go to shelf 12: accepted" in said
    assert "goal ARRIVED, Arrived at shelf 12, 18.0 m in" in said


@pytest.mark.parametrize(
    "failing", corners(["go 99", "jump"], ["cancel", "set motor_controller max_speed 9"])
)
async def test_what_succeeds_behind_a_line_that_failed_leaves_exit_code_1(failing: str) -> None:
    code, said = await plain(f"{failing}\ngo 7\n", ros_args=QUICK)
    assert code == 1, said
    assert re.search(rf"failed: (no command ')?{failing.split()[0]}[':]", said)
    assert "Arrived at shelf 7" in said


@pytest.mark.parametrize(
    ("goals", "ends", "said", "last", "arrived"),
    [
        ("go 12", "cancel", "goal CANCELLED", "go 7\n", "shelf 7"),
        ("go 12 7", "skip", "left out of the queue: 7", "", "shelf 12"),
    ],
)
async def test_one_goal_that_did_not_arrive_is_exit_code_1_whatever_arrives_behind_it(
    goals: str, ends: str, said: str, last: str, arrived: str
) -> None:
    async with operated(ros_args=LONG) as person:
        await person.enter(f"{goals}", "m left of")
        await person.enter(f"{ends}", said)
        person.type("set motor_controller time_scale 100\n")
        assert await person.end(last) == 1
        assert f"Arrived at {arrived}" in person.said
        assert "failed" not in person.said


def test_page_and_help_agree_on_the_exit_code() -> None:
    said = "exit code is 0 only when every goal arrived and every line succeeded"
    page = (ROOT / "docs" / "plain.md").read_text(encoding="utf-8")
    for text in (page, console_parser().format_help()):
        assert said in " ".join(text.split())


class Noted(Node):
    """Has a text and a list."""

    def __init__(self, **given: Any) -> None:
        super().__init__("noted", **given)
        self.declare_parameter("text", "as it was")
        self.declare_parameter("list", ["a"])


async def test_a_line_is_split_as_a_shell_does() -> None:
    lines = {
        "set noted text 'a  b'": "text is a  b,",
        "set noted text ''": "text is , was a  b",
        'set noted text "it\'s"': "text is it's,",
        "set noted text a\\ \\\\b": "text is a \\b,",
        "set noted text plain words": "text is plain words,",
        "set noted list [x, 'y z']": "list is [x, y z],",
        "set noted 'text": "failed: set: a quote is not closed",
    }
    code, said = await plain("\n".join(lines), Noted)
    assert code == 1, said
    for told in lines.values():
        assert told in said


async def test_help_is_there_at_once_and_status_waits_for_what_the_robot_has() -> None:
    async with operated(Noted, robot=ROOT / "tests/robots/cart.yaml") as person:
        begun = clock.seconds()
        await person.enter("help", "Show the state of the robot")
        assert clock.seconds() - begun < 3.0  # s; not 5
        person.type("status\n")  # its file names a battery, and no node has one
        await person.until("\nbattery NO DATA")
        assert clock.seconds() - begun < 4.5
        begun = clock.seconds()
        person.type("status\nparams\n")
        await person.until("noted text is as it was")
        assert clock.seconds() - begun < 3.0  # s; not 5


def test_a_signal_cancels_the_goal_and_ends_with_its_code() -> None:
    script = Script(*SLOW)
    script.type("go 12\n")
    script.until("m left of 1000.0 m")
    script.signal(signal.SIGTERM)
    script.until("goal CANCELLED, Cancelled mid-route")
    assert script.end() == 128 + signal.SIGTERM


@pytest.mark.parametrize(
    ("command", "code", "said"),
    [
        ("archo --plain <&-", 0, ""),
        ("archo --plain >&- </dev/null", 2, "--plain needs a standard output, and it is closed"),
        ("echo status | archo --plain >/dev/full", 1, ""),
        ("archo keys >/dev/full", 1, "cannot write to standard output: No space left"),
        ("archo keys >&-", 1, "is lost: standard output is closed"),
        ("archo status >&-", 3, "no console runs here"),
        ("archo --help >&-", 0, ""),
        (
            "(printf 'go \\355\\240\\200\\n'; yes x | tr -d '\\n' | head -c 10000000) | "
            "archo --plain",
            1,
            "",
        ),
    ],
)
def test_no_input_or_output_whatever_is_a_traceback(command: str, code: int, said: str) -> None:
    done = shell(command)
    assert b"Traceback" not in done.stderr + done.stdout
    assert b"Exception" not in done.stderr
    assert b"Broken pipe" not in done.stderr  # who reads no further knows it
    assert (done.returncode, said in done.stderr.decode()) == (code, True), done


def test_an_ascii_output_gets_ascii() -> None:
    done = shell("echo status | archo --plain", LC_ALL="C", PYTHONIOENCODING="ascii")
    assert done.returncode == 0, done
    assert done.stdout.isascii()
    assert b"battery GOOD" in done.stdout


@pytest.mark.parametrize("word", corners(["journal"], ["--help", "keys"]))
def test_a_user_without_a_home_is_no_traceback(word: str) -> None:
    code = (
        "import os, sys; os.environ.pop('HOME', None); os.environ.pop('XDG_STATE_HOME', None); "
        "os.environ.pop('XDG_CONFIG_HOME', None); import pwd; "
        "pwd.getpwuid = lambda uid: (_ for _ in ()).throw(KeyError(uid)); "
        f"from archo_tui.cli import main; sys.exit(main([{word!r}]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
