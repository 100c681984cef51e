"""The following of one topic for a screen: a view of it five times a second while it is open.

Messages are counted on the ROS thread, and decoded on threads of their own, which take a bounded
share of the time.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import AbstractAsyncContextManager
from functools import partial
from typing import Any, NoReturn, Protocol

from archo_tui.clock import Clock
from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError, in_one_line
from archo_tui.robot.messages.types import load_class
from archo_tui.robot.outcome import Outcome
from archo_tui.robot.state import FieldView, Snapshot, TopicInfo, TopicRequest, TopicView
from archo_tui.robot.topics.inspect import Inspection, MessageIntake, too_large
from archo_tui.robot.topics.rows import TopicFields, with_elements
from archo_tui.robot_file.field_units import field_units
from archo_tui.robot_file.mismatch import not_installed
from archo_tui.ros_names import package_of

PERIOD = 0.2  # Seconds between two views.
_REFIT = 2.0  # Seconds between two looks at the publishers.
SHARE = 0.2  # The share of a processor's time that decoding takes at most.
_LONG = 0.05  # Seconds of decoding after which only the newest message is decoded the next time.
_NO_ANSWER = "the console's own node does not answer"


class FollowedRobot(Protocol):
    """The part of the robot that a topic follower uses."""

    @property
    def snapshot(self) -> Snapshot:
        """Return the newest snapshot."""

    async def topic_info(self, topic: str) -> TopicInfo | Outcome:
        """Return the publishers and subscriptions of a topic; an outcome if they cannot be told."""

    def inspect(
        self, topic: str, message_class: Any, on_data: Callable[[float, bytes, bool], None]
    ) -> AbstractAsyncContextManager[Inspection]:
        """Subscribe to a topic for as long as the context is entered."""

    def resubscribe_if_needed(self, inspection: Inspection) -> None:
        """Have an inspection subscribe again if its publishers have changed their QoS.

        The call returns at once.
        """


class TopicFollower:
    """A task that shows one topic until it is cancelled, also while the topic has no publishers."""

    def __init__(
        self,
        robot: FollowedRobot,
        clock: Clock,
        topic: str,
        request: Callable[[], TopicRequest],
        show: Callable[[TopicView], None],
    ) -> None:
        self._robot, self._clock, self._topic = robot, clock, topic
        self._request, self._show = request, show

    async def run(self) -> NoReturn:
        """Show views of the topic, up to five a second, until this task is cancelled.

        While nothing can be read, as for a type that is not known or not installed, a view with a
        `fault` is shown every two seconds.
        """
        while True:
            ends, view = await self._ask(), TopicView(self._topic)
            if isinstance(ends, Outcome):
                view = view._replace(fault=ends.text)
            elif kinds := types_of(ends):
                view = view._replace(type=kinds[0], ends=ends)
                made = await in_daemon(load_class, kinds[0])
                if made is not None:
                    view = await self._follow_type(made, kinds[0], ends)
                else:
                    view = view._replace(fault=missing_type(self._topic, kinds[0]))
            else:
                view = view._replace(ends=ends, fault="it is not on the graph: waiting for it")
            self._show(view)
            await self._clock.sleep(_REFIT)

    async def _ask(self) -> TopicInfo | Outcome:
        return await self._robot.topic_info(self._topic)

    async def _follow_type(self, message_class: Any, kind: str, ends: TopicInfo) -> TopicView:
        """Show messages of a type until the topic is published with other types only."""
        snapshot, intake = self._robot.snapshot, MessageIntake()
        units = field_units(snapshot.file, snapshot.full, self._topic, kind)
        try:
            async with self._robot.inspect(self._topic, message_class, intake.add) as inspection:
                watch = TopicWatch(self._topic, kind, units, intake, inspection.decode)
                refit_at, spent = self._clock.monotonic() + _REFIT, 0.0
                while True:
                    view, spent = await in_daemon(self._update, watch, self._request(), spent)
                    known = self._robot.snapshot.message_rates.get(self._topic)
                    if view.rate is None and known is not None:
                        view = view._replace(rate=known.hertz_at(self._clock.monotonic()))
                    self._show(view._replace(ends=ends, fault=view.fault or _fault(ends, kind)))
                    await self._clock.sleep(max(PERIOD, spent / SHARE))
                    if self._clock.monotonic() < refit_at:
                        continue
                    refit_at = self._clock.monotonic() + _REFIT
                    self._robot.resubscribe_if_needed(inspection)
                    asked = await self._ask()
                    ends = ends if isinstance(asked, Outcome) else asked
                    if types_of(ends) and kind not in types_of(ends):
                        return TopicView(self._topic, ends=ends, fault="its type has changed")
        except TimeoutError:
            return TopicView(self._topic, kind, ends=ends, fault=_NO_ANSWER)
        except ArchoError as error:
            return TopicView(self._topic, kind, ends=ends, fault=str(error))

    def _update(
        self, watch: TopicWatch, request: TopicRequest, spent: float
    ) -> tuple[TopicView, float]:
        """Return the new view, and the processor time in seconds that it took."""
        begun, now = time.thread_time(), self._clock.monotonic()
        view = watch.update(now, request, only_newest=spent > _LONG)
        return view, time.thread_time() - begun


def types_of(ends: TopicInfo) -> list[str]:
    """Return the types of a topic's publishers, else of its subscriptions; sorted, each once."""
    return sorted({end.type for end in ends.publishers or ends.subscriptions})


def missing_type(topic: str, kind: str) -> str:
    """Return a text that a topic's type is not installed, and how to install it."""
    return f"{not_installed(topic, kind)}: install its package {package_of(kind)}, and restart"


def _fault(ends: TopicInfo, kind: str) -> str:
    """Return what is wrong with a topic's publishers: none, or also other types; "" if nothing."""
    if not ends.publishers:
        return "it has no publisher: waiting for one"
    others = [other for other in types_of(ends) if other != kind]
    return f"also published as {', '.join(others)}, which is not shown" if others else ""


class TopicWatch:
    """The conversion of one topic's messages into views, live and in a replay."""

    def __init__(
        self,
        topic: str,
        kind: str,
        units: Mapping[str, str],
        intake: MessageIntake,
        decode: Callable[[bytes], Any],
    ) -> None:
        self._topic, self._kind = topic, kind
        self._intake, self._decode = intake, decode
        self._fields = TopicFields(units)
        self._fault = ""  # Why the last message could not be decoded.

    def update(self, now: float, request: TopicRequest, *, only_newest: bool = False) -> TopicView:
        """Decode the messages that have come since the last call, and return a view of the topic.

        It may take long. Errors become the `fault` of the view, which then shows the last good
        message, if there was one.
        """
        waiting = self._intake.drain()
        for message in waiting[-1:] if only_newest else waiting:
            try:
                self._fields.add(message.time, self._decode(message.data), request.open_arrays)
                self._fault = ""
            except ArchoError as error:
                self._fault = str(error)
            except Exception as error:  # A hostile message may raise anything.
                self._fault = f"not shown: {in_one_line(error)}"
        fields: tuple[FieldView, ...] = ()
        try:
            fields = self._fields.rows(now, request)
        except Exception as error:  # As above.
            self._fault = f"not shown: {in_one_line(error)}"
        rates, last = self._intake.rates(now), self._intake.last
        message = self._fields.message
        is_too_large = self._intake.is_too_large
        return TopicView(
            self._topic,
            self._kind,
            received=self._intake.received,
            rate=rates and rates[0],
            bytes_per_second=rates and rates[1],
            age=None if last is None else max(now - last, 0.0),
            fields=fields,
            is_cut=self._fields.is_cut,
            plots=self._fields.plots(now, request),
            open_arrays=request.open_arrays,
            with_elements=None if message is None else partial(with_elements, message),
            fault=too_large(self._intake.last_size) if is_too_large else self._fault,
        )
