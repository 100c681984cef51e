"""The memory of a topic's fields while somebody looks at it: ranges, and a minute of values.

Pure: messages and their times come in, rows go out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from archo_tui.errors import in_one_line
from archo_tui.robot.field_history import PER_SECOND, FieldHistory
from archo_tui.robot.message_fields import field_rows
from archo_tui.robot.message_numbers import MessageNumbers, element_numbers
from archo_tui.robot.state import Curve, FieldKind, FieldView, TopicRequest, TopicView


class TopicFields:
    """The rows, ranges and curves of a topic's fields since the topic was opened.

    `add` reads the numbers of every message; `rows` describes the last message only.

    Attributes:
        is_cut: True if the message of the last `rows` has more fields than are returned.
    """

    def __init__(self, units: Mapping[str, str]) -> None:
        """Create the memory, before the first message.

        Args:
            units: The units that the robot file gives, by path.
        """
        self._units = units
        self._histories: dict[str, FieldHistory] = {}
        self._numbers: MessageNumbers | None = None  # Of the class of the last message.
        self._of_numbers: list[FieldHistory] = []  # In the order of their paths.
        self._message: Any = None  # The last one.
        self._read: tuple[Any, Mapping[str, int]] = None, {}  # What the rows were made of.
        self._rows: list[FieldView] = []
        self._shown: tuple[FieldView, ...] = ()  # The rows that were returned last.
        self.is_cut = False

    @property
    def message(self) -> Any:
        """The last message that was added; None before the first one."""
        return self._message

    def add(self, time: float, message: Any, open_arrays: Mapping[str, int]) -> None:
        """Make a message the last one, and add its numbers to ranges and curves; NaN is left out.

        It takes long for a large message, and may raise anything for one that is not as its type
        says.

        Args:
            time: When the message came, in seconds on the clock of `rows`.
            message: The message.
            open_arrays: The arrays whose elements have ranges and curves, too: as for `field_rows`.
        """
        numbers = self._numbers
        if numbers is None or type(message) is not type(self._message):
            numbers = self._numbers = MessageNumbers(message)
            self._of_numbers = [self._history(path) for path in numbers.paths]
        self._message = message
        tenth = math.floor(time * PER_SECOND)
        for history, value in zip(self._of_numbers, numbers.read(message), strict=True):
            if math.isfinite(value):
                history.add(tenth, value)
        for path, value in element_numbers(message, open_arrays):
            if math.isfinite(value):
                self._history(path).add(tenth, value)

    def _history(self, path: str) -> FieldHistory:
        return self._histories.setdefault(path, FieldHistory())

    def rows(self, now: float, request: TopicRequest) -> tuple[FieldView, ...]:
        """Return the rows of the last message, with ranges and the visible curves; () without one.

        A row that has not changed is the same object as before. It takes long for a large message.

        Args:
            now: The present time in seconds, at which curves end.
            request: The open arrays, and the paths that need a curve.
        """
        if self._message is None:
            return ()
        read, open_arrays = self._read
        if read is not self._message or open_arrays != request.open_arrays:
            self._rows, self.is_cut = field_rows(self._message, request.open_arrays)
            self._read = self._message, request.open_arrays
        before = self._shown
        rows = [self._complete(row, now, request) for row in self._rows]
        for place, (old, new) in enumerate(zip(before, rows, strict=False)):
            if old == new:
                rows[place] = old
        self._shown = tuple(rows)
        return self._shown

    def plots(self, now: float, request: TopicRequest) -> dict[str, Curve]:
        """Return the curves of the plotted fields, by path; fields without a number are left out.

        Empty if `plot_columns` is 0.

        Args:
            now: The present time in seconds, at which curves end.
            request: The paths of the fields, and the number of columns.
        """
        return {
            path: self._histories[path].curve(now, request.plot_columns)
            for path in request.plotted
            if path in self._histories and request.plot_columns
        }

    def _complete(self, row: FieldView, now: float, request: TopicRequest) -> FieldView:
        """Return a row with its unit, range and curve; the same object if there are none."""
        unit, history = self._units.get(row.path, row.unit), self._histories.get(row.path)
        if history is None or history.is_empty:
            return row._replace(unit=unit) if unit != row.unit else row
        is_seen = row.path in request.visible and request.curve_columns
        has_range = not isinstance(row.value, bool)
        return row._replace(
            unit=unit,
            least=history.least if has_range else None,
            greatest=history.greatest if has_range else None,
            curve=history.curve(now, request.curve_columns) if is_seen else (),
        )


def with_elements(message: Any, view: TopicView, open_arrays: Mapping[str, int]) -> TopicView:
    """Return a view with the elements of other arrays of the same message.

    Fields that the view has keep their ranges and curves. It takes long for a large message. An
    error becomes the `fault` of the view.

    Args:
        message: The message that the view shows.
        view: The view.
        open_arrays: The arrays whose elements to show, as for `field_rows`.
    """
    try:
        rows, is_cut = field_rows(message, open_arrays)
    except Exception as error:  # A hostile message may raise anything.
        return view._replace(fault=f"not shown: {in_one_line(error)}", open_arrays=open_arrays)
    known = {row.path: row for row in view.fields}
    fields = [
        known[row.path]._replace(is_open=row.is_open)
        if row.path in known and row.kind is not FieldKind.MORE
        else row
        for row in rows
    ]
    return view._replace(fields=tuple(fields), is_cut=is_cut, open_arrays=open_arrays)
