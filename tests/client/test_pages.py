"""docs/protocol.md, docs/shell.md and docs/python.md: what they show is what happens."""

from __future__ import annotations

import asyncio
import contextlib
import io
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from archo_tui.client.protocol import EXITS
from archo_tui.verbs import topics
from tests.support import chosen
from tests.support.console import FAST
from tests.support.shells import heard, raw, served
from tests.support.waiting import DEADLINE

pytestmark = pytest.mark.real_time

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "protocol.md").read_text()
SHELL = (DOCS / "shell.md").read_text()
NAMED = {"VERSION": r"[\w.+]+", "PID": r"\d+", "NAME": r"\d+-[0-9a-f]{8}", "AGE": r"\d+\.\d+"}


def _block(language: str) -> str:
    found = re.search(rf"^```{language}\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    assert found is not None
    return found[1]


@pytest.mark.skipif(chosen.ENGINE != "embedded", reason="the hello of the page names the engine")
async def test_the_session_of_the_page_is_what_is_said_byte_by_byte() -> None:
    async with served(ros_args=FAST, domain_id=None):
        one = await raw()
        for line in _block("").splitlines():
            if line.startswith("> "):
                one.send(f"{line[2:]}\n".encode())
                continue
            said = await asyncio.wait_for(one.reader.readline(), DEADLINE)
            wanted = re.escape(line[2:])
            for name, pattern in NAMED.items():
                wanted = re.sub(rf"\b{name}\b", lambda _, p=pattern: p, wanted)  # type: ignore[misc]
            assert re.fullmatch(wanted, said.decode().removesuffix("\n")), (line, said)
        one.close()


def test_the_exit_codes_of_the_page_are_those_that_a_shell_ends_with() -> None:
    told: dict[str, int] = {}
    for code, words in re.findall(r"^\| (\d+) \|[^|]*\| (.*?) \|$", SHELL, re.MULTILINE):
        told |= {word: int(code) for word in re.findall(r"`(\w+)`", words)}
    assert told == EXITS


NETCAT = """\
import os, select, socket, sys
folder, name = os.path.split(sys.argv[2])
os.chdir(folder)  # its whole name may be too long
console = socket.socket(socket.AF_UNIX)
console.connect(name)
while True:
    for one in select.select([0, console], [], [])[0]:
        data = os.read(0, 65536) if one == 0 else console.recv(65536)
        if not data:
            sys.exit()
        console.sendall(data) if one == 0 else os.write(1, data)
"""


@pytest.mark.skipif(shutil.which("bash") is None, reason="the lines are bash's")
async def test_the_client_in_five_lines_of_shell_sends_the_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    netcat = tmp_path / "nc"  # what it does is all that is wanted of it
    Path(f"{netcat}.py").write_text(NETCAT)
    netcat.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$0.py" "$@"\n')
    netcat.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    lines = _block("bash")
    assert len(lines.splitlines()) == 5
    async with served(ros_args=FAST) as person:
        done = await asyncio.to_thread(
            subprocess.run, ["bash", "-c", lines], capture_output=True, text=True, timeout=DEADLINE
        )
        assert json.loads(done.stdout)["code"] == "arrived", done
        await heard(person, "Arrived at shelf 12")


EXAMPLES = re.findall(r"^```python\n(.*?)^```", (DOCS / "python.md").read_text(), re.M | re.S)
PRINTED = [
    ["8", "shelf 12 Arrived at shelf 12", "0.5"],
    ["shelf 7"],
    ["misuse Shelf: at most 40, not 99", "not yet"],
    [" Arrived at shelf 3"],  # by the log or the goal, whichever comes first
    ["\n8", "{'encoder_ticks': ", " Hz\n"],  # Some 5, and less on a busy machine.
]


@pytest.mark.parametrize(("code", "lines"), [*zip(EXAMPLES, PRINTED, strict=True)])
async def test_the_examples_in_python_do_what_they_say(
    code: str, lines: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(topics, "LISTEN", 2.0)
    code = code.replace("timeout=5", "timeout=1")

    def run() -> str:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(code, {})
        return out.getvalue()

    async with served(ros_args=FAST):
        said = await asyncio.to_thread(run)
    for line in lines:
        assert line in said
