"""`echo` that follows a topic: each message, at most five a second, for as long as it is wanted."""

from __future__ import annotations

import asyncio
import json
import threading
from typing import Any

import pytest
from rclpy.node import Node
from std_msgs.msg import Float32, Header

import archo_tui
from archo_tui.robot.outcome import Outcome
from archo_tui.verbs.topics import Echo
from archo_tui.verbs.verb import prepare_when_found
from tests.support.clock import seconds
from tests.support.plain import operated
from tests.support.quiet import until, while_passes
from tests.support.ros import begin
from tests.support.shells import heard, served, typed
from tests.support.shells import until as until_beside

TALKERS: list[Talker] = []


class Talker(Node):
    """Publishes a count at 20 Hz and a header at 1 Hz."""

    def __init__(self, **options: Any) -> None:
        super().__init__("talker", **options)
        self._counts, self._fast = 0, self.create_publisher(Float32, "fast", 10)
        self._fast_timer = self.create_timer(0.05, self._publish)
        slow = self.create_publisher(Header, "slow", 10)
        self.slow_timer = self.create_timer(1.0, lambda: slow.publish(Header(frame_id="map")))
        self._silent = self.create_publisher(Header, "silent", 10)
        TALKERS[:] = [self]

    def leave_fast(self) -> None:
        """Publish nothing more on `fast`, and leave it."""
        self._fast_timer.cancel()
        self.destroy_publisher(self._fast)

    def _publish(self) -> None:
        self._counts += 1
        self._fast.publish(Float32(data=float(self._counts)))


def listens(topic: str) -> bool:
    """Return True if the console has subscribed to a topic of the talker."""
    return TALKERS[0].count_subscribers(topic) > 0


async def test_messages_are_printed_until_the_next_line_five_a_second_at_most() -> None:
    async with operated(Talker, at_terminal=True) as person:
        person.type("echo slow --follow\n")
        await person.until("following slow; the next line ends it\nstamp:\n")
        await person.until("frame_id: map\n---\nstamp:")
        await while_passes(3.0)
        began = seconds()
        person.type("echo fast --follow\n")
        await until(lambda: not listens("/slow"))
        assert 3 <= person.said.count("frame_id: map") <= 7  # None twice.
        await person.until("data: ")
        await while_passes(3.0)
        person.type("\n")
        await until(lambda: not listens("/fast"))
        lines = person.said.splitlines()
        shown = [float(line.partition(": ")[2]) for line in lines if line.startswith("data: ")]
        left_out = [int(line.split()[0]) for line in lines if line.endswith(" left out")]
        assert 10 <= len(shown) <= 5 * (seconds() - began) + 2
        assert sum(left_out) + len(shown) == pytest.approx(shown[-1] - shown[0] + 1, abs=5)
        person.type("echo silent --follow\n")
        await person.until("no message on /silent in 5 s: nothing arrived from talker")
        assert listens("/silent")
        person.type("echo nosuch --follow\n")
        await person.until("failed: echo: no topic /nosuch is on the graph")
        await until(lambda: not listens("/silent"))
        assert await person.end() == 1


async def test_that_the_publisher_has_gone_is_said_once() -> None:
    async with operated(Talker, at_terminal=True) as person:
        person.type("echo fast --follow\n")
        await person.until("data: ")
        begin(TALKERS[0], TALKERS[0].leave_fast)
        await person.until("no message on /fast in 5 s: it has no publisher")
        await while_passes(12.0)
        assert person.said.count("no publisher") == 1
        TALKERS[0].slow_timer.cancel()
        person.type("echo slow --follow\n")
        await person.until("no message on /slow in 5 s: nothing arrived from talker")
        assert await person.end() == 0


@pytest.mark.real_time
async def test_a_shell_follows_until_its_time_is_over() -> None:
    async with served(Talker) as person:
        shown = await typed("echo", "fast", "--timeout", "1")
        assert shown.code == 4
        assert shown.out.startswith("data: ")
        assert " left out\n" in shown.err
        told = await typed("echo", "fast", "--json", "--timeout", "1")
        *messages, result = map(json.loads, told.out.splitlines())
        assert result["code"] == "ran_out"
        assert [sorted(one) for one in messages] == [["left_out", "message"]] * len(messages)
        assert messages[1]["message"]["data"] > messages[0]["message"]["data"]
        await until_beside(lambda: not listens("/fast"))
        assert (await typed("echo", "fast", "--once")).code == 0
        wrong = await typed("echo", "fast", "dat")
        assert (wrong.code, wrong.err) == (
            2,
            "archo-tui: echo: there is no field dat (nearest: data)\n",
        )
        await person.end()


@pytest.mark.real_time
async def test_a_program_iterates_over_messages() -> None:
    found: list[dict[str, Any]] = []
    errors: list[str] = []

    def run() -> None:
        with archo_tui.connect() as robot:
            for message in robot.messages("fast"):
                found.append(message)
                if len(found) == 3:
                    break
            found.extend(robot.messages("slow", "frame_id", timeout=2.5))
            try:
                next(robot.messages("nosuch"))
            except archo_tui.Misused as error:
                errors.append(str(error))

    async with served(Talker) as person:
        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        await until_beside(lambda: not thread.is_alive())
        counts = [message["data"] for message in found[:3]]
        assert counts == sorted(set(counts))
        assert found[3] == {"frame_id": "map"}
        assert errors == ["no topic /nosuch is on the graph"]
        await until_beside(lambda: not (listens("/fast") or listens("/slow")))
        await heard(person, "")
        await person.end()


async def test_whoever_is_behind_is_shown_the_newest_with_a_count() -> None:
    shown: list[dict[str, Any]] = []
    may_show = False
    async with operated(Talker) as person:
        station = person._plain._station
        echo = person._plain._verbs["echo"]
        assert isinstance(echo, Echo)
        values = await prepare_when_found(station, echo, {"topic": "/fast"})
        assert not isinstance(values, Outcome)
        following = asyncio.ensure_future(
            echo.follow(
                station,
                values,
                shown.append,
                for_program=True,
                has_room=lambda: may_show,
            )
        )
        await until(lambda: listens("/fast"))
        await while_passes(2.0)
        assert not shown
        may_show = True
        await until(lambda: shown)
        assert shown[0]["left_out"] > 20
        assert "text" not in shown[0]
        following.cancel()
        await until(lambda: not listens("/fast"))
        assert await person.end() == 0
