"""The commands that help against alarms, and how to give them."""

from __future__ import annotations

from collections.abc import Mapping

from archo_tui.robot.state import Snapshot
from archo_tui.station.alarms import EARLIER_STOP, LAST_KNOWN, LOW_BATTERY, STOPPED, Alarm

_CHARGE = "charge"  # The robot file's command that charges, whatever its id is.
# Alarms that a command helps against: the command's id, and the words around the way to give it.
_REMEDIES = {
    STOPPED: ("release", ", then {} to release"),
    EARLIER_STOP: ("release", ": {} to release"),
    LOW_BATTERY: (_CHARGE, ", or {} to charge"),
}


def advice(alarm: Alarm, hints: Mapping[str, str]) -> str:
    """Return the text of an alarm, with the command that helps.

    It is the text alone if no command helps, the condition is over, or it is only the last known.

    Args:
        alarm: The alarm.
        hints: How to give each command that may help, from `remedy_hints`.
    """
    command, words = _REMEDIES.get(alarm.name, ("", ""))
    if command not in hints or alarm.is_over or alarm.text.endswith(LAST_KNOWN):
        return alarm.text
    return alarm.text + words.format(hints[command])


def remedy_hints(snapshot: Snapshot, hints_by_id: Mapping[str, str]) -> dict[str, str]:
    """Return how to give each command that helps against alarms.

    Args:
        snapshot: The state of the robot: a command that no node offers is left out.
        hints_by_id: How to give each command by its id, as `press R` or `type release`; a command
            without an entry is left out.

    Returns:
        The hints that `advice` takes: those for `release`, and for `charge`, whatever the robot
        file calls the command that charges.
    """
    robot, hints = snapshot.file, {}
    if robot.stop is not None and not snapshot.unavailable(robot.stop.release):
        hints["release"] = hints_by_id.get("release", "")
    for command in robot.commands:
        charges = "battery.charging" in command.toggle.values()
        if charges and not snapshot.unavailable(command.service):
            hints.setdefault(_CHARGE, hints_by_id.get(command.id, ""))
    return {command: hint for command, hint in hints.items() if hint}
