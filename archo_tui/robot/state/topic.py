"""A topic while somebody looks at it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum, auto
from typing import NamedTuple

from archo_tui.robot.state.graph import TopicInfo

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
    """A row for a field of a message, or for an element of an array that is open."""

    path: str  # Its dotted path: `pose.position.x`, `ranges[3]`.
    kind: FieldKind
    type: str  # Its type as .msg files write it; of an array with its length: `float32[360]`.
    value: bool | float | str | None = None  # Its value, NaN also; None for a group.
    is_time: bool = False  # True if the value is a time of day.
    unit: str = ""  # Its unit; "" if neither its definition nor the robot file names one.
    constant: str = ""  # The name that the type gives to this value, or "".
    least: float | None = None  # The least value since the topic was opened.
    greatest: float | None = None  # The greatest value, as `least`.
    nan: int = 0  # Of an array, the number of elements that are NaN.
    first: str = ""  # Of an array of bytes, the first ones in hexadecimal.
    is_open: bool = False  # True for an array whose elements follow.
    curve: Curve = ()  # Its values of the last minute; () if they were not asked for.


class TopicView(NamedTuple):
    """A topic at one moment."""

    topic: str
    type: str = ""  # The type of its messages; "" while none is known.
    received: int = 0  # The number of messages that came since the topic was opened.
    rate: float | None = None  # The messages in a second; None before three intervals.
    bytes_per_second: float | None = None  # The bytes of these messages in a second.
    age: float | None = None  # Seconds since the last message.
    fields: tuple[FieldView, ...] = ()  # The rows for the fields of the last message, in its order.
    is_cut: bool = False  # True if the message has more fields than are shown.
    # The values of the last minute by path, for those that were asked for.
    plots: Mapping[str, Curve] = {}
    ends: TopicInfo | None = None  # Its publishers and subscriptions; None if they are not known.
    fault: str = ""  # Why nothing is shown, or why not the last message; "" if nothing is wrong.
    # The arrays whose elements are among the fields: by path, the first element.
    open_arrays: Mapping[str, int] = {}
    # Takes this view and other `open_arrays`, and returns the view with the elements of these, from
    # the same message.
    with_elements: Callable[[TopicView, Mapping[str, int]], TopicView] | None = None


class TopicRequest(NamedTuple):
    """The parts of a view that a screen needs."""

    # The arrays whose elements are shown: by path, the index of the first one shown.
    open_arrays: Mapping[str, int] = {}
    # The paths of the fields whose curve is shown beside them.
    visible: frozenset[str] = frozenset()
    curve_columns: int = 0  # The number of columns of such a curve.
    plotted: tuple[str, ...] = ()  # The paths of the fields that are plotted.
    plot_columns: int = 0  # The number of columns of a plot.
