"""A newline or an escape in a parameter, or in a log line, begins no line of its own."""

from __future__ import annotations

from pathlib import Path

from tests.support.console import console
from tests.support.plain import operated

FAKED = "12:00:00 goal ABORTED"
SIGN = f"""
from rclpy.node import Node

class Sign(Node):
    def __init__(self):
        super().__init__("sign")
        text = "first\\n{FAKED}\\x1b[31m"
        self.declare_parameter("text", text)
        self.declare_parameter("texts", ["a", text])
        self.declare_parameter("name\\n{FAKED}", 1)
        self.create_timer(0.5, lambda: self.get_logger().warning(text))
"""


def sign(here: Path) -> Path:
    file = here / "sign.py"
    file.write_text(SIGN)
    return file


async def test_plain_says_each_value_and_log_line_in_one_line(here: Path) -> None:
    loads = here / "other.yaml"
    loads.write_text('sign:\n  ros__parameters:\n    text: "second\\n12:00:00 goal ABORTED"\n')
    async with operated(node_files=[sign(here)], only=True) as person:
        await person.until("WARN sign: first")
        person.type("params\nget sign text\nget sign texts\nload other.yaml\nno\nget sign text\n")
        await person.until("would be second")
        person.type("load other.yaml --yes\nget sign text\n")
        await person.until("sign text is second")
        lines = person.said.splitlines()
        assert sum(FAKED in line for line in lines) >= 7
        assert [line for line in lines if line.startswith(FAKED)] == []
        assert "\x1b[31m" not in person.said


async def test_the_screen_shows_it_in_one_line(here: Path) -> None:
    async with console(node_files=[sign(here)], only=True, wait=False) as op:
        await op.until("text")
        await op.until("first")
        lines = [line.strip(" │┃") for line in op.text.splitlines()]
        assert [line for line in lines if line.startswith(FAKED)] == []


async def test_a_long_list_is_cut_with_its_length(here: Path) -> None:
    file = here / "long.py"
    file.write_text(SIGN.replace('"name\\n12:00:00 goal ABORTED", 1', '"long", [7] * 70_000'))
    async with operated(node_files=[file], only=True) as person:
        await person.until("WARN sign: first")
        person.type("get sign long\n")
        await person.until("7, 7 ... (210000 characters), integer[]")
        assert len(person.said) < 5000
