"""The command line: every mistake of a user is one clear line and exit code 2."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest

from archo_tui import __version__
from archo_tui.cli import main
from archo_tui.cli.graph import domains_text
from archo_tui.cli.options import split_ros_args
from archo_tui.robot_file.load import default_path
from archo_tui.station import shutdown
from archo_tui.verbs import verbs
from tests.support import chosen, warm
from tests.support.archo import ARCHO
from tests.support.night import corners

Refused = Callable[..., str]
RED = "\N{REPLACEMENT CHARACTER}[31m"  # a sequence, as it is shown


def archo(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        warm.python("-m", "archo_tui", *words),
        capture_output=True,
        text=True,
        check=False,
        stdin=subprocess.DEVNULL,
        timeout=60,
    )


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """The one line that a refused start prints; in this process, where it has the engine."""

    def start(*words: str) -> str:
        if chosen.ENGINE == "embedded":
            assert main(words) == 2
            out, err = capsys.readouterr()
        else:
            done = archo(*words)
            assert done.returncode == 2
            out, err = done.stdout, done.stderr
        assert out == ""
        lines = err.strip().splitlines()
        assert len(lines) == 1, err
        assert lines[0].startswith("archo-tui: ")
        return lines[0].removeprefix("archo-tui: ")

    return start


def params(tmp_path: Path, text: str) -> str:
    file = tmp_path / "params.yaml"
    file.write_text(text)
    return str(file)


def test_a_python_that_is_too_old_is_said_in_one_line() -> None:
    code = "import sys; sys.version_info = (3, 9, 18); import archo_tui.cli"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == "archo-tui: needs Python 3.10 or newer, this is 3.9\n"


@pytest.mark.parametrize("is_zip", [True, False])
def test_it_begins_again_as_it_was_begun(
    is_zip: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[list[str]] = []
    program = tmp_path / "archo-tui.pyz"
    program.write_text("#!/usr/bin/env python3\n")
    if is_zip:
        with ZipFile(program, "a") as file:
            file.writestr("__main__.py", "")
    monkeypatch.setattr(sys, "argv", [str(program), "--node", "a.py"])
    monkeypatch.setattr("archo_tui.cli.run_words", lambda *_: shutdown.RESTART)
    monkeypatch.setattr(os, "execv", lambda _, words: begun.append(words))
    main()
    itself = [str(program)] if is_zip else ["-m", "archo_tui"]
    assert begun == [[sys.executable, *itself, "--node", "a.py"]]


def test_version_and_help() -> None:
    first, second = archo("--version").stdout.splitlines()
    assert first == f"archo-tui {__version__}"
    python = ".".join(map(str, sys.version_info[:3]))
    assert second.startswith(f"Python {python}, Textual 8.2.")
    assert second.endswith(", engine embedded, TERM xterm-256color")
    said = archo("--help").stdout
    for option in ("--params-file", "--use-sim", "--namespace", "--engine", "--ros-args"):
        assert option in said
    heads = [line for line in said.splitlines() if line.endswith(":") and line[0] != " "]
    assert heads == [
        *("examples:", "commands (archo-tui COMMAND --help says more):"),
        *("verbs (archo-tui VERB --help says more):", "your own nodes:"),
        *("the robot:", "ROS 2:", "the console:", "about:"),
    ]
    examples = said.partition("examples:\n")[2].partition("\n\n")[0].splitlines()
    assert [line[:11] for line in examples] == ["  archo-tui"] * 3
    listed = said.partition("VERB --help says more):\n")[2].partition(";")[0]
    own = {*listed.replace(",", " ").split()}
    robots = {command.id for command in ARCHO.commands} | {"discharge"}
    assert own == {*verbs(ARCHO, {})} - robots
    assert archo("help").stdout == said


@pytest.mark.parametrize(("columns", "width"), [("", 80), ("wide", 80), ("0", 80), ("60", 60)])
def test_help_is_as_wide_as_columns_say(
    columns: str, width: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", columns)
    longest = max(map(len, archo("--help").stdout.splitlines()))
    assert width - 12 < longest <= width - 2


def test_the_keymap_is_printed_in_the_form_of_its_file(tmp_path: Path, refused: Refused) -> None:
    said = archo("keys").stdout
    assert "stop: ctrl+x           # everywhere: STOP: software stop" in said
    (tmp_path / "config" / "archo-tui").mkdir(parents=True)
    file = tmp_path / "config" / "archo-tui" / "keymap.yaml"
    file.write_text(said.replace("stop: ctrl+x", "stop: f5"))
    assert "\nstop: f5 " in archo("keys").stdout
    file.write_text("reset: 1\n")
    assert refused("keys") == f"{file}:1: 1 is already the key of panel_1"


BLINK = "commands:\n  - {id: blink, title: Blink, service: blink, key: b}\n"
BEEP = "  - {id: beep, title: Beep, service: beep, key: KEY}\n"
WRONG_FILES = [
    ("name: x\nbatery: none\n", "2: unknown key batery (nearest: battery)"),
    (BLINK + BEEP.replace("KEY", "q"), "3: q is the key of quit: choose another"),
    (
        BLINK + BEEP.replace("KEY", "tab"),
        "3: tab is needed in fields and dialogs: choose another",
    ),
]


@pytest.mark.parametrize("mode", [[], ["--plain"], ["keys"]])
@pytest.mark.parametrize(("text", "said"), WRONG_FILES)
def test_a_wrong_robot_file_is_one_line_before_the_terminal_is_touched(
    mode: list[str],
    text: str,
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    file = tmp_path / "robot.yaml"
    file.write_text(text)
    monkeypatch.setattr("archo_tui.cli.console.require_terminal", lambda _: None)
    hosted = [] if mode == ["keys"] else ["--engine", chosen.ENGINE, "--only"]
    assert main([*hosted, "--robot", str(file), *mode]) == 2
    assert capsys.readouterr().err == f"archo-tui: {file}:{said}\n"


def test_nothing_that_is_printed_reaches_the_terminal_as_a_sequence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = default_path().read_text(encoding="utf-8")
    robot = tmp_path / "red.yaml"
    robot.write_text(text.replace("help: Reset the", r'help: "\e[31mReset"#'), encoding="utf-8")
    monkeypatch.setenv("TERM", "\x1b[31m")
    monkeypatch.setenv("XDG_STATE_HOME", "/tmp/\x1b[31m")
    for words in (["--version"], ["journal"], ["keys", "--robot", str(robot)]):
        assert main(words) in (0, 2)
    for words in (["--\x1b[31m"], ["\x1b[31m"], ["keys", "\x1b[31m"]):
        assert main(words) in (2, 3)
    out, err = capsys.readouterr()
    assert "\x1b" not in out + err
    assert (out.count(RED), err.count(RED)) == (3, 2)


NOBODY = "no console runs here: start archo-tui, or archo-tui --plain"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--no-such", "unrecognized arguments: --no-such (see archo-tui --help)"),
        ("--nod x.py", "unrecognized arguments: --nod, nearest: --node (see archo-tui --help)"),
        ("chek x.py", f"no command 'chek' (nearest: check), and {NOBODY}"),
        ("--only battery.py", "--only is for the console, not for battery.py"),
        ("check", "the following arguments are required: FILE (see archo-tui check --help)"),
        (
            "keys --rob x",
            "unrecognized arguments: --rob x, nearest: --robot (see archo-tui keys --help)",
        ),
        (
            "--namespace /r keys",
            "unrecognized arguments: --namespace /r (see archo-tui keys --help)",
        ),
        ("check x.py --ros-args -p a:=1", "--ros-args is for the console, not for check"),
        (
            "--params-file /no/such.yaml",
            "/no/such.yaml: cannot read the parameter file: No such file or directory",
        ),
        (
            "--namespace /dash-ed",
            "--namespace /dash-ed: only letters, digits and _ between slashes, and no digit first",
        ),
        ("--engine warp", "no engine 'warp': one of embedded, ros2"),
        (
            "--attach",
            "--attach needs --engine ros2: the embedded engine exists in this process only",
        ),
        (
            "--on-disconnect leave",
            "--on-disconnect leave needs --attach: the nodes hosted here end with the console",
        ),
    ],
)
def test_words_that_mean_nothing_are_refused(words: str, said: str, refused: Refused) -> None:
    assert refused(*words.split()).partition("; ARCHO_TUI_SOCKETS is set")[0] == said


@pytest.mark.parametrize(
    "words",
    [
        "check a.py b.py --engine ros2 --interfaces d",
        "check --engine ros2 a.py --interfaces d b.py",
        "--interfaces d --engine ros2 check a.py b.py",
    ],
)
def test_a_subcommand_takes_its_options_anywhere(
    words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    ran: list[tuple[object, ...]] = []

    def run(*given: object) -> int:
        ran.append(given[:3])
        return 0

    monkeypatch.setattr("archo_tui.cli.check.run", run)
    assert main(words.split()) == 0
    assert ran == [(["a.py", "b.py"], "ros2", [Path("d")])]


def test_each_subcommand_has_a_help_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    for name, options in (("check", "FILE"), ("keys", "--robot"), ("journal", "--help")):
        with pytest.raises(SystemExit) as ended:
            main([name, "--help"])
        said = capsys.readouterr().out
        assert ended.value.code == 0
        assert said.startswith(f"usage: archo-tui {name} [-h]")
        assert options in said
        assert "--plain" not in said


@pytest.mark.parametrize("name", ["stdin", "stdout", "stderr"])
def test_a_screen_needs_a_terminal_for_each_of_its_streams(name: str) -> None:
    master, slave = pty.openpty()
    streams: dict[str, Any] = dict.fromkeys(("stdin", "stdout"), slave)
    streams |= {"stderr": subprocess.PIPE, name: subprocess.DEVNULL}
    if name == "stderr":
        streams[name] = subprocess.PIPE
    command = [sys.executable, "-m", "archo_tui"]
    try:
        done = subprocess.run(command, check=False, timeout=60, **streams)
    finally:
        os.close(master)
        os.close(slave)
    said = f"archo-tui: {name} is not a terminal: run archo-tui in one, or use --plain\n"
    assert (done.returncode, done.stderr.decode()) == (2, said)


@pytest.mark.parametrize(
    ("text", "line", "said"),
    [
        ("a: [1, 2\nb: 3\n", 2, "not YAML"),
        ("a:\n\tb: 1\n", 2, "not YAML"),
        ("max_speed: 1.0\n", 1, "not a ROS parameter file"),
        ("- 1\n", 1, "not a ROS parameter file"),
        ("motor_controller:\n  ros__parameters:\n    max_speed: fast\n", 3, "expecting type"),
        ("motor_controller:\n  ros__parameters:\n    max_speed: 9.0\n", 3, "out of range"),
        ("/**:\n  ros__parameters:\n    drain_min: 50.0\n", 3, "above drain_max"),
        ("a:\n  ros__parameters:\n    mixed: [1, x]\n", 3, "values of one type"),
    ],
)
def test_a_bad_parameter_file_names_file_and_line(
    tmp_path: Path, text: str, line: int, said: str, refused: Refused
) -> None:
    file = params(tmp_path, text)
    message = refused("--params-file", file)
    assert message.startswith(f"{file}:{line}: ")
    assert said in message


def test_the_journals_path_is_printed() -> None:
    assert archo("journal").stdout.endswith("/state/archo-tui/journal.jsonl\n")


def test_a_bad_value_behind_ros_args_is_said(refused: Refused) -> None:
    said = refused("--ros-args", "-p", "max_speed:=9.0")
    assert said.startswith("Invalid parameter value (9.0)")  # and no file, which says 0.8
    assert "Parameter max_speed out of range" in said


def test_ros_args_are_taken_off() -> None:
    words = ["--use-sim", "--ros-args", "-p", "a:=1", "--", "--namespace", "/x"]
    assert split_ros_args(words) == (["--use-sim", "--namespace", "/x"], ["-p", "a:=1"])
    twice = ["--ros-args", "-p", "a:=1", "--ros-args", "-p", "b:=2", "--", "--only"]
    own, ros = split_ros_args(twice)  # the second one ends nothing
    assert own == ["--only"]
    assert [word for word in ros if word != "--ros-args"] == ["-p", "a:=1", "-p", "b:=2"]


def run_patched(patch: str, *words: str) -> subprocess.CompletedProcess[str]:
    """archo-tui with a part of its engine module replaced, as on another machine."""
    code = f"import sys\nfrom archo_tui.ros import engine\n{patch}\n"
    code += f"from archo_tui.cli import main\nsys.exit(main({list(words)!r}))"
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60
    )


NO_ROS = "engine.importlib.util.find_spec = lambda name: None"
NO_INTERFACES = (
    "engine.importlib.util.find_spec = lambda name: None if 'archo' in name else 1\n"
    "engine.importlib.import_module = lambda name: None"
)
STALE = (
    "engine.importlib.util.find_spec = lambda name: 1\n"
    "engine.importlib.import_module = lambda name: None"
)


@pytest.mark.parametrize(
    ("patch", "said", "hint"),
    corners(
        [(NO_ROS, "ROS 2 was not found", "pip install '.[ros2]' ./interfaces")],
        [
            (NO_INTERFACES, "archo_interfaces is not installed", "pip install ./interfaces"),
            (STALE, "archo_interfaces is out of date, it lacks msg/BatteryStatus", "colcon build"),
        ],
    ),
)
def test_a_lack_of_ros_is_one_line_with_what_to_type(patch: str, said: str, hint: str) -> None:
    done = run_patched(patch, "--engine", "ros2")
    assert done.returncode == 2
    assert len(done.stderr.strip().splitlines()) == 1
    assert said in done.stderr
    assert hint in done.stderr


def test_each_domain_with_nodes_is_a_line_with_how_to_start_there() -> None:
    found = {7: ["/a", "/b", "/c", "/d", "/e", "/f"], 0: ["/base"]}
    assert domains_text(found).splitlines() == [
        "domain 0: /base: start with ROS_DOMAIN_ID=0",
        "domain 7: /a, /b, /c, /d and 2 more: start with ROS_DOMAIN_ID=7",
    ]


def test_nothing_found_is_said_with_what_limits_the_look() -> None:
    said = domains_text({})
    assert said.startswith("no node in the domains 0 to 20")
    assert "ROS_AUTOMATIC_DISCOVERY_RANGE" in said
