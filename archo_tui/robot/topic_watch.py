"""A topic while somebody looks at it: what waits is decoded, and becomes a view."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from archo_tui.errors import ArchoError, in_one_line
from archo_tui.robot.inspection import too_large
from archo_tui.robot.message_intake import MessageIntake
from archo_tui.robot.state import FieldView, TopicRequest, TopicView
from archo_tui.robot.topic_fields import TopicFields, with_elements


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
        """Create the watch, before the first message.

        Args:
            topic: The full name of the topic.
            kind: The type of its messages.
            units: The units that the robot file gives, by path.
            intake: Collects the messages, which other threads add.
            decode: Returns the message that some bytes encode; raises ArchoError if there is none.
        """
        self._topic, self._kind = topic, kind
        self._intake, self._decode = intake, decode
        self._fields = TopicFields(units)
        self._fault = ""  # Why the last message could not be decoded.

    def update(self, now: float, request: TopicRequest, *, only_newest: bool = False) -> TopicView:
        """Decode the messages that have come since the last call, and return a view of the topic.

        It may take long. Errors become the `fault` of the view, which then shows the last good
        message, if there was one.

        Args:
            now: The present time, on the clock of the messages, in seconds.
            request: What the view has to have.
            only_newest: True to decode the newest message only; the others are only counted.
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
