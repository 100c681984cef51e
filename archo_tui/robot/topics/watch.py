"""A topic while somebody looks at it: what waits is decoded, and becomes a view.

Messages are counted on the ROS thread, and decoded on threads of their own, which take a bounded
share of the time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from archo_tui.errors import ArchoError, in_one_line
from archo_tui.robot.state.graph import TopicInfo
from archo_tui.robot.state.topic import FieldView, TopicRequest, TopicView
from archo_tui.robot.topics.inspect import MessageIntake, too_large
from archo_tui.robot.topics.rows import TopicFields, with_elements
from archo_tui.robot_file.check import not_installed
from archo_tui.ros_names import package_of

PERIOD = 0.2  # Seconds between two views.
SHARE = 0.2  # The share of a processor's time that decoding takes at most.


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


def types_of(ends: TopicInfo) -> list[str]:
    """Return the types of a topic's publishers, else of its subscriptions; sorted, each once."""
    return sorted({end.type for end in ends.publishers or ends.subscriptions})


def missing_type(topic: str, kind: str) -> str:
    """Return a text that a topic's type is not installed, and how to install it."""
    return f"{not_installed(topic, kind)}: install its package {package_of(kind)}, and restart"


def publisher_fault(ends: TopicInfo, kind: str) -> str:
    """Return what is wrong with the publishers of a topic that is shown as a type, or ""."""
    if not ends.publishers:
        return "it has no publisher: waiting for one"
    others = [other for other in types_of(ends) if other != kind]
    return f"also published as {', '.join(others)}, which is not shown" if others else ""
