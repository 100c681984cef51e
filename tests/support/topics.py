"""A topic as an inspector sees it, with a field of every kind."""

from __future__ import annotations

from archo_interfaces.msg import BatteryStatus

from archo_tui.robot.state.graph import TopicEnd, TopicInfo
from archo_tui.robot.topics.inspect import MessageIntake, TopicWatch
from archo_tui.robot.topics.rows import (
    FieldKind,
    FieldView,
    TopicRequest,
    TopicView,
    shown_elements,
)
from tests.support.clock import TIME

TYPE = "archo_interfaces/msg/BatteryStatus"
_END = TopicEnd("/battery_monitor", TYPE, "RELIABLE, VOLATILE")
ENDS = TopicInfo(
    (_END,), (_END._replace(node="/dashboard"), _END._replace(node="/_archo_console_lab_1"))
)
_RANGES = 360


def topic_view(topic: str, request: TopicRequest) -> TopicView:
    """Return a topic after a minute of messages at 2 Hz."""
    intake, charges = MessageIntake(), iter(range(120))

    def decode(_: bytes) -> BatteryStatus:
        number = next(charges)
        charge = 87.5 - number / 20 - (15 if number == 60 else 0)
        return BatteryStatus(
            percentage=charge, voltage=24.5, is_charging=40 <= number < 80, battery_health="good"
        )

    units = {"percentage": "%", "voltage": "V"}  # As a robot file may name them.
    watch = TopicWatch(topic, TYPE, units, intake, decode)
    for number in range(120):
        now = TIME - 60 + number / 2
        intake.add(now, bytes(24))
        watch.update(now, request)
    view = watch.update(TIME, request)
    return view._replace(
        fields=(*view.fields, *_others(request)),
        ends=ENDS,
        with_elements=lambda _, arrays: topic_view(topic, request._replace(open_arrays=arrays)),
    )


def _others(request: TopicRequest) -> list[FieldView]:
    """Return further fields, which the type of the topic does not have."""
    value, array = FieldKind.VALUE, FieldKind.ARRAY
    begin = request.open_arrays.get("ranges")
    rows = [
        FieldView("header", FieldKind.GROUP, "std_msgs/Header"),
        FieldView("header.stamp", value, "builtin_interfaces/Time", TIME - 0.4, is_time=True),
        FieldView("header.frame_id", value, "string", "base_link"),
        FieldView("status", value, "uint8", 4, constant="FULL", least=1, greatest=4),
        FieldView(
            "ranges", array, f"float32[{_RANGES}]", _RANGES, unit="m", least=0.12, greatest=9.8,
            nan=3, is_open=begin is not None,
        ),
    ]  # fmt: skip
    if begin is not None:
        shown = shown_elements(begin, _RANGES)
        rows += [FieldView(f"ranges[{n}]", value, "float32", n / 40) for n in shown]
        rows.append(FieldView("ranges[]", FieldKind.MORE, "", _RANGES))
    return [*rows, FieldView("image", array, "uint8[921600]", first="00 01 02 03 04 05 06 07")]
