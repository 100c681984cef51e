"""The units that a robot file gives to fields of messages."""

from __future__ import annotations

from collections.abc import Callable

from archo_tui.robot_file.model import MessageField, RobotFile


def field_units(
    file: RobotFile, full_name: Callable[[str], str], topic: str, type_name: str
) -> dict[str, str]:
    """Return the units of a topic's fields by path, as far as the robot file tells them.

    A field with a scale, an offset or a condition is left out: its unit in the message is unknown.
    """
    found: list[tuple[MessageField | None, str]] = []
    if file.battery is not None and full_name(file.battery.topic) == topic:
        battery = file.battery.types.get(type_name)
        if battery is not None:
            found += [(battery.percentage, "%"), (battery.voltage, "V")]
    if file.pose is not None and full_name(file.pose.topic) == topic:
        pose = file.pose.types.get(type_name)
        if pose is not None:
            found += [(pose.x, "m"), (pose.y, "m")]
    if file.motion is not None and full_name(file.motion.topic) == topic:
        motion = file.motion.types.get(type_name)
        if motion is not None:
            found += [(motion.count, ""), (motion.speed, "")]
    found += [
        (gauge.field, gauge.unit)
        for gauge in file.gauges
        if full_name(gauge.topic) == topic and gauge.type == type_name
    ]
    return {
        field.field: field.unit or unit
        for field, unit in found
        if field is not None and _is_unconverted(field) and (field.unit or unit)
    }


def _is_unconverted(field: MessageField) -> bool:
    is_number = field.equals is None and field.beyond is None
    return field.scale == 1.0 and field.offset == 0.0 and is_number
