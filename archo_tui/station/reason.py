"""The rule for how long the reason of a refusal is shown: until a possible cause is over. Pure.

The robot refuses in its own words, which the console does not understand. So every fact that may
have been the cause is watched.
"""

from __future__ import annotations

from collections.abc import Callable

from archo_tui.robot.state import Phase, Snapshot
from archo_tui.station.conditions import battery_health, is_battery_low

Facts = frozenset[tuple[object, ...]]  # Each a name, and what else tells it from others.


class CauseWatch:
    """A watch on the facts that may be why something was refused.

    The text about a refusal is shown until one of these facts is over.
    """

    def __init__(self, facts: Callable[[Snapshot], Facts]) -> None:
        """Create a watch, which has not recorded any facts yet.

        Args:
            facts: Returns the possible causes in a snapshot: `refusal_causes` or `limits`.
        """
        self._facts = facts
        self._before: Facts = frozenset()

    def observe(self, snapshot: Snapshot) -> bool:
        """Record the facts in a snapshot; return True if one that the last call recorded has ended.

        The first call returns False. A new fact alone does not count: a topic may report the cause
        after the refusal.
        """
        before, self._before = self._before, self._facts(snapshot)
        return not before <= self._before


def refusal_causes(snapshot: Snapshot) -> Facts:
    """Return the facts in a snapshot for which the robot may refuse a request.

    Each parameter with its value is a fact, so that a changed value ends one.
    """
    battery, motion = snapshot.battery, snapshot.motion
    goal, robot = snapshot.goal, snapshot.file
    names = {kind.action for kind in robot.goals} | {given.service for given in robot.commands}
    found: list[tuple[object, ...]] = [
        ("goal", None if goal is None else goal.sent),
        ("running", snapshot.running),
        *(("is offered", name, name in snapshot.offered) for name in names),
        *(("parameter", p.node, p.name, repr(p.value)) for p in snapshot.parameters),
        *(("gauge", reading.gauge.title) for reading in snapshot.gauges if reading.warning),
    ]
    flags = {
        "goal runs": goal is not None and goal.is_running,
        "goal in doubt": goal is not None and goal.phase in (Phase.UNKNOWN, Phase.LOST),
        "empty": battery.percentage is not None and battery.percentage <= 0.0,
        "low": is_battery_low(snapshot),
        "replace": battery_health(snapshot) == "replace",
        "charging": battery.charging,
        "moving": motion.moving,
        "stopped": snapshot.is_stopped,
    }
    return frozenset(found + [(name,) for name, holds in flags.items() if holds])


def limits(snapshot: Snapshot) -> Facts:
    """Return the least and greatest values that the robot allows in goals now.

    There is a fact for each field of a goal that has limits.
    """
    return frozenset(
        (kind.id, path, given.low, given.high)
        for kind in snapshot.file.goals
        for path, given in snapshot.form(kind).items()
    )
