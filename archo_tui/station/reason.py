"""How long a reason that was given holds: until something that it may be about is over. Pure."""

from __future__ import annotations

from collections.abc import Callable

from archo_tui.robot.state import Phase, Snapshot
from archo_tui.station.alarm_conditions import battery_health, is_battery_low

Facts = frozenset[tuple[object, ...]]


class Reason:
    """A reason that is shown, in words that the console need not understand."""

    def __init__(self, facts: Callable[[Snapshot], Facts]) -> None:
        """Create a reason that holds until one of its facts is over.

        Args:
            facts: Return everything that the reason may be about, as it is in a snapshot.
        """
        self._facts = facts
        self._before: Facts = frozenset()

    def is_over(self, snapshot: Snapshot) -> bool:
        """Return whether a fact that held at the last call has ended.

        The first call only notes the facts. One that is added is no end: a topic may report it
        after the refusal that it caused.
        """
        before, self._before = self._before, self._facts(snapshot)
        return not before <= self._before


def obstacles(snapshot: Snapshot) -> Facts:
    """Return what may have the robot refuse something now."""
    battery, motion = snapshot.battery, snapshot.motion
    goal, robot = snapshot.goal, snapshot.file
    names = {kind.action for kind in robot.goals} | {given.service for given in robot.commands}
    found: list[tuple[object, ...]] = [
        ("goal", None if goal is None else goal.sent),
        ("running", snapshot.running),
        *(("is offered", name, name in snapshot.offered) for name in names),
        *(("parameter", one.node, one.name, repr(one.value)) for one in snapshot.parameters),
        *(("gauge", one.gauge.title) for one in snapshot.gauges if one.warns),
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
    """Return what the goals of the robot file may be, as the robot has it now."""
    return frozenset(
        (kind.id, path, given.low, given.high)
        for kind in snapshot.file.goals
        for path, given in snapshot.form(kind).items()
    )
