"""`archo-tui completions`: each shell that is installed takes what is printed."""

from __future__ import annotations

import asyncio
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from archo_tui.base.paths import state_file
from archo_tui.cli import main
from archo_tui.cli.completion import fitting
from archo_tui.console import session
from archo_tui.recordings import recorder, store
from tests.assistant.support import listening
from tests.support import clock
from tests.support.shells import guest, served, typed

# One line for each shell, as docs/shell.md has it, and what must run before it.
LINES = {
    "bash": 'eval "$(archo-tui completions bash)"',
    "zsh": 'eval "$(archo-tui completions zsh)"',
    "fish": "archo-tui completions fish | source",
}
BEFORE = {"zsh": "autoload -U compinit && compinit -u -D; "}
ASKED = {"bash": "complete -p archo-tui", "fish": "complete -C 'archo-tui cancel --al'"}
ASKED["zsh"] = "print ${_comps[archo-tui]}"


COMPLETED = """
source completions
COMP_LINE="archo-tui $*"
COMP_POINT=${#COMP_LINE}
_python_argcomplete archo-tui
printf '%s\\n' "${COMPREPLY[@]}"
"""
needs_bash = pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")


@pytest.fixture
def run(tmp_path: Path) -> Callable[..., str]:
    """Run a script of a shell in `tmp_path`, where `archo-tui` is on the PATH."""
    program = tmp_path / "bin" / "archo-tui"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m archo_tui "$@"\n')
    program.chmod(0o755)
    path = f"{program.parent}:{os.environ['PATH']}"

    def run_it(shell: str, script: str, *words: str) -> str:
        done = subprocess.run(
            [shell, "-c", script, *words],
            capture_output=True,
            text=True,
            check=False,
            cwd=tmp_path,
            env={**os.environ, "PATH": path},
        )
        assert (done.returncode, done.stderr) == (0, "")
        return done.stdout

    return run_it


@pytest.fixture
def offered(run: Callable[..., str], tmp_path: Path) -> Callable[..., list[str]]:
    """What bash offers for the last of the words behind `archo-tui`, by the printed script."""
    (tmp_path / "completions").write_text(run("bash", "archo-tui completions bash"))
    return lambda *words: run("bash", COMPLETED, "bash", *words).split()


@pytest.mark.parametrize("shell", LINES)
def test_one_line_installs_the_completions_of_a_shell(shell: str, run: Callable[..., str]) -> None:
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    said = run(shell, f"{BEFORE.get(shell, '')}{LINES[shell]}\n{ASKED[shell]}")
    assert ("--all" if shell == "fish" else "_python_argcomplete") in said
    page = Path(__file__).parents[2] / "docs" / "shell.md"
    assert LINES[shell] in page.read_text(encoding="utf-8")


KNOWN = [
    (("sta",), ["start", "status"]),
    (("--wat",), ["--watch"]),
    (("go", "--w"), ["--wait"]),
    (("cancel", "--a"), ["--all"]),
    (("completions", "fi"), ["fish"]),
    (("--engine", "r"), ["ros2"]),
    (("launch", "--on-disconnect", ""), ["cancel", "leave"]),
    (("launch", "comp"), ["completions"]),
    (("check", "--interfaces", ""), ["bin/", "completions"]),
    (("load", "comp"), ["completions"]),
]


@needs_bash
def test_bash_completes_what_is_known_without_a_console(offered: Callable[..., list[str]]) -> None:
    for words, wanted in KNOWN:
        assert sorted(offered(*words)) == wanted, words


@needs_bash
@pytest.mark.real_time
async def test_bash_completes_recordings_and_the_files_beside_them(
    offered: Callable[..., list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder, "SECONDS_AFTER", 0.1)
    async with served() as person:
        await typed("keep")
        await person.end()
    (recording,) = store.list_recordings(state_file("recordings"))
    assert offered("recordings", "--delete", "20") == [recording.name]
    assert offered("replay", "20") == [recording.name]
    assert offered("replay", "comp") == ["completions"]


@needs_bash
@pytest.mark.real_time
async def test_bash_completes_what_the_console_knows_and_leaves_no_event(
    offered: Callable[..., list[str]],
) -> None:
    async with served() as person:
        while "shelf_count" not in (await typed("params")).out:
            await asyncio.sleep(0.01)
        before = person.said
        assert await asyncio.to_thread(offered, "go", "--wait", "39") == ["39"]
        assert await asyncio.to_thread(offered, "stop", "") == []
        assert await asyncio.to_thread(offered, "call", "emergency") == ["emergency_stop"]
        assert await asyncio.to_thread(offered, "disch") == ["discharge"]  # of the robot file
        assert await asyncio.to_thread(offered, "pub", "--r") == ["--rate"]
        assert person.said == before
        await person.end()


@pytest.mark.parametrize("words", [("stop",), ("stop", ""), ("call", "emergency_stop", "")])
async def test_the_question_of_a_completion_is_never_a_stop(words: tuple[str, ...]) -> None:
    async with served() as person, guest() as client:
        client.send({"id": 1, "complete": [*words]})
        assert (await client.result())["code"] == "done"
        assert "STOP" not in person.said
        await person.end()


def test_without_a_console_nothing_is_offered_and_nothing_complained(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for words in (["go", ""], ["go", "--to", ""], ["stop", ""], ["mcp", "--to", ""]):
        assert fitting(words) == []
    assert capsys.readouterr() == ("", "")


@pytest.mark.real_time
def test_a_suspended_console_delays_a_completion_by_less_than_a_second() -> None:
    with listening("/"):
        began = clock.seconds()
        assert fitting(["go", ""]) == []
        assert clock.seconds() - began < 1


@pytest.mark.real_time
async def test_a_name_that_a_shell_would_run_is_not_offered(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    names = ["$(reboot)", "a b", "`reboot`", "max_speed", "a;reboot", "*"]
    monkeypatch.setattr(session, "candidates", lambda *_: names)
    async with served() as person:
        offered = await asyncio.to_thread(fitting, ["get", "motor_controller", ""])
        await person.end()
    assert offered == ["max_speed"]


def test_a_stop_is_sent_though_one_variable_of_completions_is_set(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("_ARGCOMPLETE", "1")
    assert main(["stop"]) == 3
    assert "STOP was not sent: no console runs here" in capsys.readouterr().err
