"""battery_level: who publishes it, and who warns of it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from statistics import median
from typing import Any

from rclpy.qos import QoSReliabilityPolicy

from archo_tui.chapter import names
from archo_tui.chapter.asker import ANSWER, Asker, CrashedError
from archo_tui.chapter.tap import Result
from archo_tui.hosting.host import HostedNode
from archo_tui.robot import message_classes

LEVEL = "battery_level"
_MOTOR = "motor_controller"
_KIND = "battery_level is a std_msgs/msg/Float32"
_KIND_OF_ARCHO = "battery_level is an archo_interfaces/msg/BatteryStatus, as ARCHO's own"
_RATE = "battery_level is published about once a second"
_FALLS = "the battery level never rises, and is within 0 .. 100"
_WARNS = "a level below 20 % is logged as a warning, any other is not"
_WARNS_BELOW = "a level below 20 % is logged as a warning"
_FLOAT = "std_msgs/msg/Float32"
_KINDS = {_FLOAT: _KIND, "archo_interfaces/msg/BatteryStatus": _KIND_OF_ARCHO}
_OWN = ("rosout", "parameter_events")  # every node's
_PERIOD = 0.5, 1.5  # s between two battery levels, where the chapter asks for one a second
_LEVELS = 5  # battery levels that are looked at
_WARN = 30  # of log levels
_AGAIN = 0.1  # s between two battery levels that the checker publishes
_EACH = 0.5  # s in which a warning that must not come would
_HIGH = 87.5, 55.0, 21.0  # levels of which nobody is to warn
_LOW = 19.0, 5.0  # and those of which everybody is


def topics(asker: Asker) -> Iterator[Result]:
    """The four checks."""
    heard: list[float] = []
    yield from _battery(asker, heard)
    yield _dashboard(asker, heard)


def _ends(ends: Iterable[Any]) -> dict[str, Any]:
    """Publishers or subscriptions by their topics, but for those of every node and of actions."""
    return {
        end.topic_name.lstrip("/"): end
        for end in ends
        if end.topic_name.lstrip("/") not in _OWN and "/_action/" not in end.topic_name
    }


def _battery(asker: Asker, heard: list[float]) -> Iterator[Result]:
    ends = asker.look(lambda node: _ends(node.publishers))
    nodes = [hosted for hosted, topics in ends.items() if LEVEL in topics]
    if not nodes:
        others = {f"/{name}" for topics in ends.values() for name in topics}
        for title in (_KIND, _RATE, _FALLS):
            yield names.missing(asker, title, LEVEL, "publish", "topic", others)
        return
    publisher = ends[nodes[0]][LEVEL]
    wrong = _wrong_type(publisher.msg_type)
    title = _KINDS.get(message_classes.name_of(publisher.msg_type), _KIND)
    yield Result(title, f"{asker.place_of_text(LEVEL)}it is {wrong}" if wrong else "")
    times: list[float] = []

    def take(message: Any) -> None:
        times.append(asker.now())
        heard.append(level_of(message))

    subscription = asker.node.create_subscription(publisher.msg_type, LEVEL, take, 10)
    longest = _LEVELS * _PERIOD[1]
    try:
        asker.until(lambda: len(times) >= _LEVELS, longest, nodes)
        said = _silence(asker, nodes, publisher, len(times), longest)
    except CrashedError as error:
        said = str(error)
    finally:
        asker.node.destroy_subscription(subscription)
    if len(times) < 2:
        yield Result(_RATE, said)
        yield Result(_FALLS, "too few messages to tell")
        return
    period = median(b - a for a, b in pairwise(times))
    where = asker.place(nodes, lambda source: source.line_of_call("create_timer"))
    slow = f"{where}one every {period:.2f} s: the first argument of create_timer is in seconds"
    well = _PERIOD[0] <= period <= _PERIOD[1]
    yield Result(_RATE, said if len(times) < _LEVELS else "" if well else slow)
    wrong = _wrong_levels(heard)
    yield Result(_FALLS if wrong else _levels_seen(heard), wrong)


def _silence(
    asker: Asker, nodes: Sequence[HostedNode], publisher: Any, count: int, seconds: float
) -> str:
    """Why there are too few messages."""
    said = f"{count} messages in {seconds:g} s"
    busy = asker.busy(nodes)
    if busy:
        return f"{said}: a callback does not return, {busy}: use create_timer(1.0, ...)"
    if publisher.qos_profile.reliability == QoSReliabilityPolicy.BEST_EFFORT:
        reliable = "so a subscription that asks for reliable hears nothing: pass 10"
        return f"{said}: its QoS is best effort, {reliable}"
    where = asker.place(nodes, lambda source: source.line_of_call("create_timer"))
    return f"{where}{said}: create_timer(1.0, ...), in seconds, and publish() in its callback"


def _wrong_levels(levels: Sequence[float]) -> str:
    said = f"heard {', '.join(f'{level:g}' for level in levels)}"
    if all(level == 0.0 for level in levels):
        return f"{said}: the message's data is never set: message.data = self.level"
    if all(0.0 <= level <= 1.0 for level in levels):
        return f"{said}: a level is in percent, 0 .. 100, not a fraction of 1"
    if not all(0.0 <= level <= 100.0 for level in levels):
        return f"{said}: a level is in percent, 0 .. 100"
    falls = all(b <= a for a, b in pairwise(levels))
    return "" if falls else f"{said}: a battery that drains only falls"


def _levels_seen(levels: Sequence[float]) -> str:
    first, last = levels[0], levels[-1]
    if first == last:
        return f"the battery level stays at {last:g}, within 0 .. 100"
    return f"the battery level falls from {first:g} to {last:g}, within 0 .. 100"


def level_of(message: Any) -> float:
    """The level of a message, nan when it has none."""
    value = getattr(message, "percentage", getattr(message, "data", None))
    return float(value) if isinstance(value, (int, float)) else float("nan")


def _wrong_type(made: Any) -> str:
    """What is wrong with a type for battery levels; "" where it fits."""
    name = message_classes.name_of(made)
    return "" if name in _KINDS else f"a {name}; the chapter's is a {_FLOAT}"


def _dashboard(asker: Asker, heard: list[float]) -> Result:
    ends = asker.look(lambda node: _ends(node.subscriptions))
    # the motor may listen, too: it stops where the battery is empty
    ends = {h: topics for h, topics in ends.items() if h.name.rpartition("/")[2] != _MOTOR}
    nodes = [hosted for hosted, topics in ends.items() if LEVEL in topics]
    if not nodes:
        others = {f"/{name}" for topics in ends.values() for name in topics}
        return names.missing(asker, _WARNS, LEVEL, "subscribe to", "topic", others)
    subscription = ends[nodes[0]][LEVEL]
    made, where = subscription.msg_type, asker.place_of(subscription.callback)
    wrong = _wrong_type(made)
    if wrong:
        return Result(
            _WARNS, f"{asker.place_of_text(LEVEL)}the type that is subscribed to is {wrong}"
        )
    publisher = asker.node.create_publisher(made, LEVEL, 10)
    subscribed = asker.node.create_subscription(
        made, LEVEL, lambda message: heard.append(level_of(message)), 10
    )

    def is_low() -> bool:
        """A battery of the learner's own may be, by itself."""
        return any(level < 20.0 for level in heard)

    try:
        said, title = "", _WARNS
        for level in _HIGH:
            said = said or _needless(asker, nodes, publisher, level)
        # the warning may have been heard before the level
        if said and asker.until(is_low, _AGAIN):
            said, title = "", _WARNS_BELOW  # whether it warns of others could not be seen
        for level in _LOW:
            said = said or _lacking(asker, nodes, publisher, level)
            if not said:  # one that warns once warns again when the battery was charged meanwhile
                _published(asker, nodes, publisher, _HIGH[0], _EACH)
        return Result(title, where + said if said else "")
    except CrashedError as error:
        return Result(_WARNS, str(error))
    finally:
        asker.node.destroy_subscription(subscribed)
        asker.node.destroy_publisher(publisher)


def _published(
    asker: Asker, nodes: Sequence[HostedNode], publisher: Any, level: float, seconds: float
) -> str:
    """The first warning while a level is published again and again; "" when there is none.

    Again and again: the publisher may not have met the node yet.
    """
    message = publisher.msg_type()
    setattr(message, "percentage" if hasattr(message, "percentage") else "data", level)
    if hasattr(message, "battery_health"):
        message.battery_health = "good" if level >= 20.0 else "warning"
    since = len(asker.logs)

    def warnings() -> list[str]:
        return [log.msg for log in asker.logged(nodes, since) if log.level >= _WARN]

    publisher.publish(message)
    timer = asker.node.create_timer(_AGAIN, lambda: publisher.publish(message))
    try:
        asker.until(warnings, seconds, nodes)
    finally:
        asker.node.destroy_timer(timer)
    return next(iter(warnings()), "")


def _needless(asker: Asker, nodes: Sequence[HostedNode], publisher: Any, level: float) -> str:
    said = _published(asker, nodes, publisher, level, _EACH)
    if not said:
        return ""
    return f"{level} was published, and it warned: {said!r}: only below 20.0"


def _lacking(asker: Asker, nodes: Sequence[HostedNode], publisher: Any, level: float) -> str:
    logs, lines = len(asker.logs), len(asker.printed)
    if _published(asker, nodes, publisher, level, ANSWER):
        return ""
    warn = "self.get_logger().warning(...)"
    for log in asker.logged(nodes, logs):
        if _is_warning(log.msg):
            return f"{level} was published, and {log.msg!r} only logged as information: {warn}"
    for line in asker.printed[lines:]:
        if _is_warning(line):
            return f"{level} was published, and {line!r} only printed: {warn}"
    busy = asker.busy(nodes)
    if busy:
        return f"{level} was published, and nothing logged: a callback does not return, {busy}"
    return f"{level} was published, and nothing logged as a warning: {warn} below 20.0"


def _is_warning(text: str) -> bool:
    return any(word in text.lower() for word in ("low", "warn", "critical"))
