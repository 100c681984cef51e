"""The request that publishes a message to a topic."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Mapping
from typing import Any

from archo_tui.robot.clients import current_requester
from archo_tui.robot.messages import ros2_command
from archo_tui.robot.messages.types import load_class
from archo_tui.robot.messages.values import filled
from archo_tui.robot.node import DEADLINE
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.parts import Parts
from archo_tui.robot.requests.commands import run
from archo_tui.robot.state.audit_records import AuditRecord
from archo_tui.robot.stop.gate import HOLDS, Gate
from archo_tui.robot.topics.publications import CANCEL, PAUSE, Publication
from archo_tui.robot_file import check

_LONGEST_BLOCK = 0.5  # Seconds.
_POLL_PERIOD = 0.02  # Seconds between two looks whether it has ended.


async def publish(
    robot: Parts,
    topic: str,
    type_name: str,
    values: Mapping[str, Any],
    rate: float,
    times: int | None,
    *,
    moves: bool,
) -> Outcome:
    """Publish a message `times` times at `rate` Hz, for ever if None; return how it ended.

    It ends, too, when the task is cancelled, and, if it `moves` the robot, at a STOP: behind one
    it is refused.
    """
    message_class = load_class(type_name)
    if message_class is None:
        return Outcome(Code.REFUSED, check.not_installed(topic, type_name))
    try:
        message = filled(message_class(), values)
    except ValueError as error:
        return Outcome(Code.MISUSE, str(error))
    title, requester = f"pub {topic.lstrip('/')}", current_requester()
    arguments = {"topic": topic, "values": values, "rate": rate, "times": times}
    begun: list[Publication] = []
    has_left = threading.Event()

    def on_end(publication: Publication) -> None:
        robot.snapshots.send_soon()
        if times == 1 and not publication.ended:
            return  # Its one message is told already.
        record = AuditRecord("pub", arguments, publication.outcome.code)
        text = f"{title}: {publication.outcome.text}"
        robot.reporter.report_done(text, record, requester=requester)

    async def work(gate: Gate) -> Outcome:
        def is_stopped() -> bool:
            is_void = gate.is_shut or not robot.stops.are_answered
            return moves and not robot.stop_sender.stop.lets_publish(is_void=is_void)

        def why_end() -> str:
            if is_stopped():
                return "STOP"
            return "its requester" if has_left.is_set() else ""

        gate()
        if robot.goals.sending_has_ended:
            return Outcome(Code.CANCELLED, "not published: the console ends")
        if is_stopped():
            return Outcome(Code.REFUSED, HOLDS)
        publication = Publication(
            *(robot, robot.publications, topic, message, rate, times, why_end, on_end)
        )
        await publication.begin()
        begun.append(publication)
        if publication.ended:
            return publication.outcome
        heard, unfit = publication.subscriber_counts()
        who = f"{heard or 'no'} subscriber{'s' * (heard != 1)}"
        who += f"; {unfit} of another type or QoS" if unfit else ""
        if publication.is_over:
            return Outcome(Code.DONE, f"published; {who}")
        return Outcome(Code.ACCEPTED, f"publishing at {rate:g} Hz; {who}")

    command = ros2_command.publish(topic, type_name, message, rate, times)
    try:
        outcome = await run(robot, "pub", arguments, title, command, work)
        if not begun or begun[0].is_over:
            return outcome
        while not begun[0].is_over:
            await robot.clock.sleep(_POLL_PERIOD)
    finally:
        has_left.set()  # Of one that runs on, since the task was cancelled.
    return begun[0].outcome


async def end_publications(robot: Parts) -> str:
    """End all that this console publishes, as by cancel; return the topics, "" for none."""

    async def there() -> str:
        return robot.publications.end_all(CANCEL)

    if robot.publications.active:
        with contextlib.suppress(TimeoutError):
            return await robot.thread.run(there, DEADLINE)
    return ""


def end_publications_now(robot: Parts) -> None:
    """End all that this console publishes, and block until it is done, 0.5 s at most."""
    done = threading.Event()

    def end() -> None:
        robot.publications.end_all(PAUSE)
        done.set()

    until = time.monotonic() + _LONGEST_BLOCK
    if robot.thread.submit_in_handler(end, _LONGEST_BLOCK):
        done.wait(max(until - time.monotonic(), 0.0))
