"""A topic at one moment: the fields of its last message, and how often messages come."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum, auto
from typing import NamedTuple

from archo_tui.robot.state.topic_info import TopicInfo

Range = tuple[float, float]  # The least and the greatest value.
Curve = tuple[Range | None, ...]  # The values of the last minute, the oldest first; None: no value.


SHOWN_ELEMENTS = 20  # Of an open array.


class FieldKind(Enum):
    """The kinds of rows of a message."""

    VALUE = auto()  # A number, a text, a bool or a time.
    GROUP = auto()  # A message, whose fields follow.
    ARRAY = auto()
    MORE = auto()  # The elements of an open array that are not shown.


class FieldView(NamedTuple):
    """A row for a field of a message, or for an element of an array that is open.

    Attributes:
        path: Its dotted path: `pose.position.x`, `ranges[3]`.
        kind: The kind of the row.
        type: Its type as .msg files write it; of an array with its length: `float32[360]`.
        value: Its value, NaN also; None for a group. A time of day is in Unix seconds. For ARRAY
            and MORE, the length of the array.
        is_time: True if the value is a time of day.
        unit: Its unit; "" if neither its definition nor the robot file names one.
        constant: The name that the type gives to this value, or "".
        least: The least value since the topic was opened; of an array, of its elements now.
        greatest: The greatest value, as `least`.
        nan: Of an array, the number of elements that are NaN.
        first: Of an array of bytes, the first ones in hexadecimal.
        is_open: True for an array whose elements follow.
        curve: Its values of the last minute; () if they were not asked for.
    """

    path: str
    kind: FieldKind
    type: str
    value: bool | float | str | None = None
    is_time: bool = False
    unit: str = ""
    constant: str = ""
    least: float | None = None
    greatest: float | None = None
    nan: int = 0
    first: str = ""
    is_open: bool = False
    curve: Curve = ()


class TopicView(NamedTuple):
    """A topic at one moment.

    Attributes:
        topic: Its full name.
        type: The type of its messages; "" while none is known.
        received: The number of messages that came since the topic was opened.
        rate: The messages in a second; None before three intervals.
        bytes_per_second: The bytes of these messages in a second; None as for `rate`.
        age: Seconds since the last message; None before the first one that was sent since the topic
            was opened.
        fields: The rows for the fields of the last message, in its order.
        is_cut: True if the message has more fields than are shown.
        plots: The values of the last minute by path, for those that were asked for.
        ends: Its publishers and subscriptions; None if they are not known.
        fault: Why nothing is shown, or why not the last message; "" if nothing is wrong.
        open_arrays: The arrays whose elements are among the fields: by path, the first element.
        with_elements: Takes this view and other `open_arrays`, and returns the view with the
            elements of these, from the same message. It takes long for a large message, and may be
            called on any thread. None before the first message.
    """

    topic: str
    type: str = ""
    received: int = 0
    rate: float | None = None
    bytes_per_second: float | None = None
    age: float | None = None
    fields: tuple[FieldView, ...] = ()
    is_cut: bool = False
    plots: Mapping[str, Curve] = {}
    ends: TopicInfo | None = None
    fault: str = ""
    open_arrays: Mapping[str, int] = {}
    with_elements: Callable[[TopicView, Mapping[str, int]], TopicView] | None = None


class TopicRequest(NamedTuple):
    """The parts of a view that a screen needs.

    Attributes:
        open_arrays: The arrays whose elements are shown: by path, the index of the first one shown.
        visible: The paths of the fields whose curve is shown beside them.
        curve_columns: The number of columns of such a curve.
        plotted: The paths of the fields that are plotted.
        plot_columns: The number of columns of a plot.
    """

    open_arrays: Mapping[str, int] = {}
    visible: frozenset[str] = frozenset()
    curve_columns: int = 0
    plotted: tuple[str, ...] = ()
    plot_columns: int = 0
