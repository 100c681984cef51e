"""`--plain`: commands on standard input, an event a line, an exit code for scripts."""

from __future__ import annotations

import re
import signal
import subprocess
import sys

import pytest

from tests.support.console import FAST as QUICK
from tests.support.plain import plain
from tests.support.script import FAST, SLOW, Script, shell


def test_a_goal_that_arrives_is_exit_code_0() -> None:
    script = Script(*FAST)
    assert script.end("go 12\n") == 0, script.said
    assert "YOU console: go to shelf 12: accepted" in script.said
    assert re.search(r"goal MOVING to 12 \d+\.\d m left of 18\.0 m", script.said)
    assert "goal ✓ ARRIVED Arrived at shelf 12, 18.0 m in" in script.said


@pytest.mark.parametrize("last", ["go 12\nquit\n", "go 12"])
async def test_the_end_waits_for_the_goal_however_it_is_asked_for(last: str) -> None:
    code, said = await plain(last, ros_args=QUICK)
    assert code == 0, said
    assert "goal ✓ ARRIVED Arrived at shelf 12, 18.0 m in" in said


def test_a_goal_that_is_cancelled_is_exit_code_1() -> None:
    script = Script(*SLOW)
    script.type("go 12\n")
    script.until("m left of 18.0 m")
    assert script.end("cancel\n") == 1
    assert "goal ✗ CANCELLED Cancelled mid-route" in script.said


def test_stop_ends_the_goal_and_is_released() -> None:
    script = Script(*SLOW)
    script.type("go 12\n")
    script.until("m left of 18.0 m")
    script.type("stop\n")
    script.until("✗ ABORTED Emergency stop,")
    script.until("alarm unacknowledged: STOPPED: look for the cause")
    assert script.end("go 3\nrelease\ngo 7\ncancel\n") == 1
    assert "failed: go: emergency stop: release it first" in script.said
    assert "go to shelf 7: accepted" in script.said


async def test_a_refused_goal_may_be_tried_again() -> None:
    code, said = await plain("go 99\ngo 7\n", ros_args=QUICK)
    assert code == 0, said
    assert "failed: go: shelf 99 is not in 1 .. 40" in said


async def test_what_cannot_be_done_is_one_line_and_exit_code_1() -> None:
    wrong = {
        "go 99": "failed: go: shelf 99 is not in 1 .. 40",
        "go there": "failed: go: Shelf: not a whole number: there",
        "go 1_2": "failed: go: Shelf: not a whole number: 1_2",
        "set motor_controller max_speed 1_0.5": "failed: set: not a number: 1_0.5",
        "go": "failed: go: Shelf: type a value",
        "jump": "failed: jump: no command 'jump' (help lists them)",
        "set motor_controller max_speed 9": "failed: set: allowed 0.05 .. 2, not 9",
        "set motor_controller max_speed nan": "failed: set: not a finite number: nan",
        "set motor_controller ticks_per_revolution 5": "ticks_per_revolution is read-only",
        "cancel": "failed: cancel: no goal is running",
    }
    code, output = await plain("\n".join(wrong), ros_args=QUICK)
    assert code == 1
    for said in wrong.values():
        assert said in output
    assert "Traceback" not in output


@pytest.mark.parametrize("typed", ["go 99", "jump", "cancel"])
async def test_one_of_them_alone_is_exit_code_1(typed: str) -> None:
    assert (await plain(f"{typed}\n", ros_args=QUICK))[0] == 1


async def test_what_is_asked_is_told() -> None:
    typed = "set motor_controller max_speed 0.5\nreset\ncharge\nparams\nstatus\nhelp\n"
    code, said = await plain(typed, ros_args=QUICK)
    assert code == 0, said
    assert "YOU console: set motor_controller max_speed 0.5: max_speed is 0.5" in said
    assert "motor_controller max_speed 0.5* double 0.05 .. 2" in said
    assert "YOU console: reset encoder: Encoder reset to zero" in said
    assert "YOU console: charge: Charging" in said
    assert "goal No goal yet." in said
    assert "\nbattery " in said
    assert "go N " in said


def test_a_signal_cancels_the_goal_and_ends_with_its_code() -> None:
    script = Script(*SLOW)
    script.type("go 12\n")
    script.until("m left of 18.0 m")
    script.signal(signal.SIGTERM)
    script.until("goal ✗ CANCELLED Cancelled mid-route")
    assert script.end() == 128 + signal.SIGTERM


@pytest.mark.parametrize(
    ("command", "code", "said"),
    [
        ("archo --plain <&-", 0, ""),
        ("archo --plain >&- </dev/null", 2, "--plain needs a standard output, and it is closed"),
        ("echo status | archo --plain >/dev/full", 1, ""),
        ("archo --keys >/dev/full", 1, "cannot write to standard output: No space left"),
        ("archo --keys >&-", 0, ""),
        ("archo --help >&-", 0, ""),
        ("echo nonsense | archo --plain 2>&-", 1, ""),
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
    assert (done.returncode, said in done.stderr.decode()) == (code, True), done


def test_an_ascii_output_gets_ascii() -> None:
    done = shell("echo status | archo --plain", LC_ALL="C", PYTHONIOENCODING="ascii")
    assert done.returncode == 0, done
    assert done.stdout.isascii()
    assert b"battery * GOOD" in done.stdout


@pytest.mark.parametrize("option", ["--help", "--keys", "--journal"])
def test_a_user_without_a_home_is_no_traceback(option: str) -> None:
    code = (
        "import os, sys; os.environ.pop('HOME', None); os.environ.pop('XDG_STATE_HOME', None); "
        "os.environ.pop('XDG_CONFIG_HOME', None); import pwd; "
        "pwd.getpwuid = lambda uid: (_ for _ in ()).throw(KeyError(uid)); "
        f"from archo_tui.cli import main; sys.exit(main([{option!r}]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
