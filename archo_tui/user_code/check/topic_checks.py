"""The checks of the topic battery_level: its publisher, and the node that warns."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from statistics import median
from typing import Any

from archo_tui.robot.messages.types import load_class
from archo_tui.ros_names import base_name
from archo_tui.user_code.check import near_names
from archo_tui.user_code.check.check_runner import ANSWER, CheckedNode, CheckRunner, CrashedError
from archo_tui.user_code.check.tap import Result

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
_EVERY_NODES = ("rosout", "parameter_events")
_PERIOD = 0.5, 1.5  # Seconds between two levels; the chapter asks for one.
_MIN_LEVELS = 5  # Battery levels that are examined.
_WARN_LEVEL = 30  # rcl_interfaces/msg/Log.WARN.
_REPEAT = 0.1  # Seconds between two levels that the checker publishes.
_NO_WARNING_TIME = 0.5  # Seconds in which a needless warning would come.
_GOOD_LEVELS = 87.5, 55.0, 21.0  # No node may warn of these.
_LOW_LEVELS = 19.0, 5.0  # A node must warn of each of these.


def topic_checks(runner: CheckRunner) -> Iterator[Result]:
    """Yield the outcome of the four checks of the topic: type, rate, values, and the warning."""
    levels: list[float] = []
    yield from _publisher_checks(runner, levels)
    yield _warning_check(runner, levels)


def _others(topics: Iterable[str]) -> set[str]:
    """Return the topics but those of actions, and those that every node has."""
    return {f"/{name}" for name in topics if name not in _EVERY_NODES and "/_action/" not in name}


def _publisher_checks(runner: CheckRunner, levels: list[float]) -> Iterator[Result]:
    """Yield the outcome of the checks of type, rate and values of the published levels.

    If no node publishes the topic, all are skipped; they fail if a node publishes one with a
    similar name.
    """
    found = runner.nodes()
    nodes = [node for node in found if LEVEL in node.publishers]
    if not nodes:
        others = _others(name for node in found for name in node.publishers)
        for title in (_KIND, _RATE, _FALLS):
            yield near_names.missing_result(runner, title, LEVEL, "publish", "topic", others)
        return
    publisher = nodes[0].publishers[LEVEL]
    wrong = _type_hint(publisher["type"])
    title = _KINDS.get(publisher["type"], _KIND)
    yield Result(title, f"{runner.find_text(LEVEL)}it is {wrong}" if wrong else "")
    times: list[float] = []

    def take(message: Any) -> None:
        times.append(runner.now())
        levels.append(level_of(message))

    kind = load_class(publisher["type"])
    subscription = runner.node.create_subscription(kind, LEVEL, take, 10)
    longest = _MIN_LEVELS * _PERIOD[1]
    try:
        runner.spin_until(lambda: len(times) >= _MIN_LEVELS, longest, nodes)
        hint = _silence_hint(runner, nodes, publisher, len(times), longest)
    except CrashedError as error:
        hint = str(error)
    finally:
        runner.node.destroy_subscription(subscription)
    if len(times) < 2:
        yield Result(_RATE, hint)
        yield Result(_FALLS, "too few messages to tell")
        return
    period = median(b - a for a, b in pairwise(times))
    where = runner.find_line(nodes, lambda source: source.line_of_call("create_timer"))
    slow = f"{where}one every {period:.2f} s: the first argument of create_timer is in seconds"
    well = _PERIOD[0] <= period <= _PERIOD[1]
    yield Result(_RATE, hint if len(times) < _MIN_LEVELS else "" if well else slow)
    wrong = _level_range_hint(levels)
    yield Result(_FALLS if wrong else _level_range_title(levels), wrong)


def _silence_hint(
    runner: CheckRunner,
    nodes: Sequence[CheckedNode],
    publisher: dict[str, Any],
    count: int,
    seconds: float,
) -> str:
    """Return the hint for a topic with too few messages, with their likely cause and its place."""
    hint = f"{count} messages in {seconds:g} s"
    busy = runner.busy_line(nodes)
    if busy:
        return f"{hint}: a callback does not return, {busy}: use create_timer(1.0, ...)"
    if publisher["is_best_effort"]:
        reliable = "so a subscription that asks for reliable hears nothing: pass 10"
        return f"{hint}: its QoS is best effort, {reliable}"
    where = runner.find_line(nodes, lambda source: source.line_of_call("create_timer"))
    return f"{where}{hint}: create_timer(1.0, ...), in seconds, and publish() in its callback"


def _level_range_hint(levels: Sequence[float]) -> str:
    """Return what is wrong with the levels of a draining battery, or "".

    They must be in 0 .. 100 and never rise, and not all be 0 or below 1, as fractions are.
    """
    hint = f"heard {', '.join(f'{level:g}' for level in levels)}"
    if all(level == 0.0 for level in levels):
        return f"{hint}: the message's data is never set: message.data = self.level"
    if all(0.0 <= level <= 1.0 for level in levels):
        return f"{hint}: a level is in percent, 0 .. 100, not a fraction of 1"
    if not all(0.0 <= level <= 100.0 for level in levels):
        return f"{hint}: a level is in percent, 0 .. 100"
    falls = all(b <= a for a, b in pairwise(levels))
    return "" if falls else f"{hint}: a battery that drains only falls"


def _level_range_title(levels: Sequence[float]) -> str:
    """Return the title of a passed check, with the first and the last level that was received."""
    first, last = levels[0], levels[-1]
    if first == last:
        return f"the battery level stays at {last:g}, within 0 .. 100"
    return f"the battery level falls from {first:g} to {last:g}, within 0 .. 100"


def level_of(message: Any) -> float:
    """Return the charge in a message, of its field `percentage` or else `data`; nan without one."""
    value = getattr(message, "percentage", getattr(message, "data", None))
    return float(value) if isinstance(value, (int, float)) else float("nan")


def _type_hint(name: str) -> str:
    """Return what is wrong with a type for battery levels, or ""."""
    return "" if name in _KINDS else f"a {name}; the chapter's is a {_FLOAT}"


def _warning_check(runner: CheckRunner, levels: list[float]) -> Result:
    """Publish good and low levels, and return whether a node warns of the low ones alone.

    Nodes named motor_controller do not count, because they may subscribe for another purpose. If no
    other node subscribes, the check is skipped; it fails if a node subscribes to a similar name. If
    the learner's own battery publishes low levels, only the warnings of low levels are checked,
    under another title.
    """
    # The motor may subscribe as well, to stop when the battery is empty.
    found = [node for node in runner.nodes() if base_name(node.name) != _MOTOR]
    nodes = [node for node in found if LEVEL in node.subscriptions]
    if not nodes:
        others = _others(name for node in found for name in node.subscriptions)
        return near_names.missing_result(runner, _WARNS, LEVEL, "subscribe to", "topic", others)
    subscription = nodes[0].subscriptions[LEVEL]
    where, wrong = subscription["place"], _type_hint(subscription["type"])
    if wrong:
        return Result(_WARNS, f"{runner.find_text(LEVEL)}the type that is subscribed to is {wrong}")
    message_class = load_class(subscription["type"])
    publisher = runner.node.create_publisher(message_class, LEVEL, 10)
    subscribed = runner.node.create_subscription(
        message_class, LEVEL, lambda message: levels.append(level_of(message)), 10
    )

    def is_low() -> bool:
        """Return True if any level so far is below 20 %; the learner's battery may publish one."""
        return any(level < 20.0 for level in levels)

    try:
        hint, title = "", _WARNS
        for level in _GOOD_LEVELS:
            hint = hint or _try_good_level(runner, nodes, publisher, level)
        # The level may arrive here after the warning about it.
        if hint and runner.spin_until(is_low, _REPEAT):
            hint, title = "", _WARNS_BELOW  # Needless warnings cannot be told from these.
        for level in _LOW_LEVELS:
            hint = hint or _try_low_level(runner, nodes, publisher, level)
            if not hint:  # A node may warn once until the battery is charged.
                _first_warning(runner, nodes, publisher, _GOOD_LEVELS[0], _NO_WARNING_TIME)
        return Result(title, where + hint if hint else "")
    except CrashedError as error:
        return Result(_WARNS, str(error))
    finally:
        runner.node.destroy_subscription(subscribed)
        runner.node.destroy_publisher(publisher)


def _first_warning(
    runner: CheckRunner, nodes: Sequence[CheckedNode], publisher: Any, level: float, seconds: float
) -> str:
    """Publish a battery level until a node warns; return the warning, or "" if none comes in time.

    The level is published every 0.1 s, because subscriptions may not be matched yet.
    """
    message = publisher.msg_type()
    setattr(message, "percentage" if hasattr(message, "percentage") else "data", level)
    if hasattr(message, "battery_health"):
        message.battery_health = "good" if level >= 20.0 else "warning"
    since = len(runner.logs)

    def warnings() -> list[str]:
        return [log.msg for log in runner.logs_of(nodes, since) if log.level >= _WARN_LEVEL]

    publisher.publish(message)
    timer = runner.node.create_timer(_REPEAT, lambda: publisher.publish(message))
    try:
        runner.spin_until(warnings, seconds, nodes)
    finally:
        runner.node.destroy_timer(timer)
    return next(iter(warnings()), "")


def _try_good_level(
    runner: CheckRunner, nodes: Sequence[CheckedNode], publisher: Any, level: float
) -> str:
    """Publish a level of 20 % or more for 0.5 s; return the hint if a node warns of it, or ""."""
    hint = _first_warning(runner, nodes, publisher, level, _NO_WARNING_TIME)
    if not hint:
        return ""
    return f"{level} was published, and it warned: {hint!r}: only below 20.0"


def _try_low_level(
    runner: CheckRunner, nodes: Sequence[CheckedNode], publisher: Any, level: float
) -> str:
    """Publish a level below 20 % until a node warns; return the hint if none does in 3 s, or ""."""
    logs, lines = len(runner.logs), len(runner.printed)
    if _first_warning(runner, nodes, publisher, level, ANSWER):
        return ""
    warn = "self.get_logger().warning(...)"
    for log in runner.logs_of(nodes, logs):
        if _sounds_like_warning(log.msg):
            return f"{level} was published, and {log.msg!r} only logged as information: {warn}"
    for line in runner.printed[lines:]:
        if _sounds_like_warning(line):
            return f"{level} was published, and {line!r} only printed: {warn}"
    busy = runner.busy_line(nodes)
    if busy:
        return f"{level} was published, and nothing logged: a callback does not return, {busy}"
    return f"{level} was published, and nothing logged as a warning: {warn} below 20.0"


def _sounds_like_warning(text: str) -> bool:
    return any(word in text.lower() for word in ("low", "warn", "critical"))
