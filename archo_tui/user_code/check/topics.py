"""The checks of the topic battery_level: its publisher, and the node that warns."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from statistics import median
from typing import Any

from rclpy.qos import QoSReliabilityPolicy
from std_msgs.msg import Float32

from archo_tui.robot.messages.types import load_class
from archo_tui.robot.state.graph import LEVELS
from archo_tui.user_code.check.checker import (
    ANSWER,
    PUBLISHERS,
    SUBSCRIPTIONS,
    CheckedNode,
    Checker,
)
from archo_tui.user_code.check.tap import Failed

_LEVEL = "/battery_level"
_FLOAT = "std_msgs/msg/Float32"
_STATUS = "archo_interfaces/msg/BatteryStatus"
_PERIOD = 0.5, 1.5  # Seconds between two levels; the chapter asks for one.
_MIN_LEVELS = 5  # Battery levels that are examined.
_LOW = 20.0  # %
_REPEAT = 0.1  # Seconds between two levels that the checker publishes.
_NO_WARNING_TIME = 0.5  # Seconds in which a needless warning would come.
_GOOD_LEVELS = 87.5, 55.0, 21.0  # No node may warn of these.
_LOW_LEVELS = 19.0, 5.0  # A node must warn of each of these.


def check_type(checker: Checker) -> str | None:
    """Check the type of the published topic; return a title for that of ARCHO's own."""
    nodes = checker.nodes_with(PUBLISHERS, _LEVEL)
    kind = checker.load_type(nodes, PUBLISHERS, _LEVEL, [_FLOAT, _STATUS])
    return None if kind is Float32 else f"battery_level is an {_STATUS}, as ARCHO's own"


def check_rate(checker: Checker) -> None:
    """Receive five levels, and check the time between them."""
    nodes = checker.nodes_with(PUBLISHERS, _LEVEL)
    seconds = _MIN_LEVELS * _PERIOD[1]
    kind = load_class(nodes[0].has["publishers"][_LEVEL]["type"])
    with _received_levels(checker, kind):
        has_come = checker.until(lambda: len(checker.levels) >= _MIN_LEVELS, seconds, nodes)
    where = checker.line(nodes, lambda source: source.line_of_call("create_timer"))
    if not has_come:
        hint = f"{len(checker.levels)} messages in {seconds:g} s"
        if stuck := checker.stuck(nodes):
            raise Failed(f"{hint}{stuck}: use create_timer(1.0, ...)")
        publishers = checker.node.get_publishers_info_by_topic(_LEVEL)
        if QoSReliabilityPolicy.BEST_EFFORT in [p.qos_profile.reliability for p in publishers]:
            reliable = "so a subscription that asks for reliable hears nothing: pass 10"
            raise Failed(f"{hint}: its QoS is best effort, {reliable}")
        how = "create_timer(1.0, ...), in seconds, and publish() in its callback"
        raise Failed(f"{where}{hint}: {how}")
    period = median(later - at for (at, _), (later, _) in pairwise(checker.levels))
    if not _PERIOD[0] <= period <= _PERIOD[1]:
        how = "the first argument of create_timer is in seconds"
        raise Failed(f"{where}one every {period:.2f} s: {how}")


def check_levels(checker: Checker) -> str:
    """Check the levels that have come, and return a title that names the first and the last."""
    checker.nodes_with(PUBLISHERS, _LEVEL)
    levels = [level for _, level in checker.levels]
    if len(levels) < 2:
        raise Failed("too few messages to tell")
    heard = f"heard {', '.join(f'{level:g}' for level in levels)}"
    if not any(levels):
        raise Failed(f"{heard}: the message's data is never set: message.data = self.level")
    if all(0.0 <= level <= 1.0 for level in levels):
        raise Failed(f"{heard}: a level is in percent, 0 .. 100, not a fraction of 1")
    if not all(0.0 <= level <= 100.0 for level in levels):
        raise Failed(f"{heard}: a level is in percent, 0 .. 100")
    if any(later > level for level, later in pairwise(levels)):
        raise Failed(f"{heard}: a battery that drains only falls")
    first, last = levels[0], levels[-1]
    does = f"stays at {last:g}" if first == last else f"falls from {first:g} to {last:g}"
    return f"the battery level {does}, within 0 .. 100"


def check_warning(checker: Checker) -> str | None:
    """Publish good and low levels, and check that a node warns of the low ones alone.

    A motor_controller does not count: it may subscribe to stop when the battery is empty. If the
    learner's own battery is low meanwhile, needless warnings cannot be told from those of it, and
    the returned title claims no more.
    """
    nodes = checker.nodes_with(SUBSCRIPTIONS, _LEVEL, but="motor_controller")
    where, title = nodes[0].has["subscriptions"][_LEVEL]["place"], None
    kind = checker.load_type(nodes, SUBSCRIPTIONS, _LEVEL, [_FLOAT, _STATUS])
    publisher = checker.node.create_publisher(kind, _LEVEL, 10)
    try:
        with _received_levels(checker, kind):
            for level in _GOOD_LEVELS:
                needless = _first_warning(checker, nodes, publisher, level, _NO_WARNING_TIME)
                # The level may arrive here after the warning about it.
                if needless and checker.until(lambda: _has_low_level(checker), _REPEAT):
                    title = "a level below 20 % is logged as a warning"
                    break
                if needless:
                    hint = f"{level} was published, and it warned: {needless!r}"
                    raise Failed(f"{where}{hint}: only below {_LOW}")
            for level in _LOW_LEVELS:
                logs, lines = len(checker.logs), len(checker.printed)
                if not _first_warning(checker, nodes, publisher, level, ANSWER):
                    hint = _missing_warning_hint(checker, nodes, logs, lines)
                    raise Failed(f"{where}{level} was published, and {hint}")
                # A node may warn once until the battery is charged.
                _first_warning(checker, nodes, publisher, _GOOD_LEVELS[0], _NO_WARNING_TIME)
    finally:
        checker.node.destroy_publisher(publisher)
    return title


@contextmanager
def _received_levels(checker: Checker, kind: Any) -> Iterator[None]:
    """Add the levels that are published meanwhile to those of the checker."""

    def add(message: Any) -> None:
        level: Any = getattr(message, "percentage", getattr(message, "data", None))
        is_text = not isinstance(level, (int, float))
        checker.levels.append((checker.now(), math.nan if is_text else level))

    subscription = checker.node.create_subscription(kind, _LEVEL, add, 10)
    try:
        yield
    finally:  # On ROS 2, a process cannot have the topic with a second type.
        checker.node.destroy_subscription(subscription)


def _has_low_level(checker: Checker) -> bool:
    return any(level < _LOW for _, level in checker.levels)


def _first_warning(
    checker: Checker, nodes: Sequence[CheckedNode], publisher: Any, level: float, seconds: float
) -> str:
    """Publish a battery level until a node warns; return the warning, or "" if none comes in time.

    The level is published every 0.1 s, because subscriptions may not be matched yet.
    """
    message = publisher.msg_type()
    setattr(message, "percentage" if hasattr(message, "percentage") else "data", level)
    if hasattr(message, "battery_health"):
        message.battery_health = "good" if level >= _LOW else "warning"
    since = len(checker.logs)

    def warnings() -> list[str]:
        logs = checker.logs_of(nodes, since)
        return [log.msg for log in logs if log.level >= LEVELS["WARN"]]

    publisher.publish(message)
    timer = checker.node.create_timer(_REPEAT, lambda: publisher.publish(message))
    try:
        checker.until(warnings, seconds, nodes)
    finally:
        checker.node.destroy_timer(timer)
    return next(iter(warnings()), "")


def _missing_warning_hint(
    checker: Checker, nodes: Sequence[CheckedNode], logs: int, lines: int
) -> str:
    """Return what nodes did in place of a warning, since so many `logs` and printed `lines`."""
    warn = "self.get_logger().warning(...)"
    told = [(log.msg, "logged as information") for log in checker.logs_of(nodes, logs)]
    told += [(line, "printed") for line in checker.printed[lines:]]
    for text, how in told:
        if any(word in text.lower() for word in ("low", "warn", "critical")):
            return f"{text!r} only {how}: {warn}"
    stuck = checker.stuck(nodes)
    return f"nothing logged{stuck}" if stuck else f"nothing logged as a warning: {warn} below 20.0"
