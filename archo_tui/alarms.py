"""Alarms as a state machine: active or over, times unacknowledged or acknowledged.

An alarm is gone only when it is over and acknowledged. Pure: conditions and times come in.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from archo_tui.robot.state import Snapshot

CONTACT_LOST, EMPTY, STOPPED, LOW = "contact lost", "battery empty", "stopped", "low battery"
ORDER = (CONTACT_LOST, EMPTY, STOPPED, LOW)  # the worst first

ON_DELAY = {LOW: 2.0, EMPTY: 2.0}  # s that a condition must hold before it is an alarm


@dataclass(frozen=True)
class Alarm:
    """One alarm: `text` says what and what to do, `since` and `until` are Unix times."""

    name: str
    text: str
    since: float
    until: float | None = None
    acknowledged: bool = False

    @property
    def is_over(self) -> bool:
        """True when its condition no longer holds."""
        return self.until is not None


def conditions(snapshot: Snapshot, now: float) -> dict[str, str]:
    """Which alarms' conditions hold at `now` (monotonic s), with the text for each."""
    battery, motor = snapshot.battery, snapshot.motor
    found: dict[str, str] = {}
    if (battery.received is not None or motor.received is not None) and (
        (battery.received is None or battery.is_old(now))
        and (motor.received is None or motor.is_old(now))
    ):
        # one cause, one alarm: what was last heard says nothing about now
        heard = max(battery.received or 0.0, motor.received or 0.0)
        return {
            CONTACT_LOST: f"CONTACT LOST for {now - heard:.0f} s: the robot may still be moving"
        }
    moving = snapshot.goal is not None and snapshot.goal.is_running
    dock = "dock the robot when this move is done" if moving else "dock the robot"
    if battery.percentage is not None and not battery.is_old(now):
        if battery.percentage <= 0.0:
            found[EMPTY] = "BATTERY EMPTY: the robot refuses moves, charge it where it stands"
        elif is_low(snapshot) and not battery.charging:
            found[LOW] = f"LOW BATTERY {battery.percentage:.1f} %: {dock}"
    if motor.stopped:
        found[STOPPED] = "STOPPED: look for the cause, then R releases"
    return found


def is_low(snapshot: Snapshot) -> bool:
    """The robot's own judgement; without one, its percentage against the threshold."""
    battery = snapshot.battery
    if battery.health is not None:
        return battery.health == "warning"
    return battery.percentage is not None and battery.percentage < snapshot.threshold


class AlarmBoard:
    """The alarms that are not gone yet."""

    def __init__(self) -> None:
        self._alarms: dict[str, Alarm] = {}
        self._pending: dict[str, float] = {}  # condition -> monotonic s since it holds

    def update(self, found: dict[str, str], monotonic: float, now: float) -> None:
        """Take the conditions that hold now (`conditions`); `now` is a Unix time."""
        self._pending = {name: self._pending.get(name, monotonic) for name in found}
        for name, text in found.items():
            known = self._alarms.get(name)
            if known is None or known.is_over:
                if monotonic - self._pending[name] >= ON_DELAY.get(name, 0.0):
                    self._alarms[name] = Alarm(name, text, now)
            elif known.text != text:
                self._alarms[name] = replace(known, text=text)
        for name, alarm in list(self._alarms.items()):
            if name not in found and not alarm.is_over:
                self._alarms[name] = replace(alarm, until=now)
        self._drop_gone()

    def acknowledge(self) -> Alarm | None:
        """Acknowledge the alarm that is shown; returns it."""
        shown = self.shown()
        if shown is None or shown.acknowledged:
            return None
        self._alarms[shown.name] = replace(shown, acknowledged=True)
        self._drop_gone()
        return shown

    def all(self) -> tuple[Alarm, ...]:
        """What needs attention first: unacknowledged, then active, then by ORDER."""
        return tuple(
            sorted(
                self._alarms.values(),
                key=lambda a: (a.acknowledged, a.is_over, ORDER.index(a.name)),
            )
        )

    def shown(self) -> Alarm | None:
        """The one for the banner."""
        alarms = self.all()
        return alarms[0] if alarms else None

    def _drop_gone(self) -> None:
        for name, alarm in list(self._alarms.items()):
            if alarm.is_over and alarm.acknowledged:
                del self._alarms[name]
