"""The rule for how long the reason of a refusal is shown: until a possible cause is over. Pure.

The robot refuses in its own words, which the console does not understand. So every fact that may
have been the cause is watched.
"""

from __future__ import annotations

from collections.abc import Callable

from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.station.conditions import battery_health, is_battery_low

Facts = frozenset[tuple[object, ...]]  # Each a name, and what else tells it from others.


class CauseWatch:
    """A watch on the facts that may be why something was refused."""

    def __init__(self, facts: Callable[[Snapshot], Facts]) -> None:
        self._facts = facts
        self._before: Facts = frozenset()

    def observe(self, snapshot: Snapshot) -> bool:
        """Record the facts; return True if one that the last call recorded has ended.

        A new fact alone does not count: a topic may report the cause after the refusal.
        """
        before, self._before = self._before, self._facts(snapshot)
        return not before <= self._before


def refusal_causes(snapshot: Snapshot) -> Facts:
    """Return the facts for which the robot may refuse a request, such as parameters' values."""
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
    """Return the least and greatest values that the robot allows in goals now, as facts."""
    return frozenset(
        (kind.id, path, given.low, given.high)
        for kind in snapshot.file.goals
        for path, given in snapshot.form(kind).items()
    )
