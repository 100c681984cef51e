"""What a robot file fixes and converts is checked as what is typed is."""

from __future__ import annotations

import math
from typing import Any

import pytest

pytest.importorskip("depot_interfaces")

from depot_interfaces.action import GoTo, Haul, Inspect

from archo_tui.robot.messages.values import goal_request
from archo_tui.robot_file.model import FormField, GoalKind

YAW = {"target.pose.orientation": FormField(label="yaw", convert="yaw")}


def kind(**given: Any) -> GoalKind:
    return GoalKind(id="go", title="Go", action="go", type="depot_interfaces/action/GoTo", **given)


def test_a_yaw_in_degrees_is_sent_as_a_quaternion() -> None:
    made = goal_request(GoTo, kind(form=YAW), {"target.pose.orientation": 90.0})
    turned = made.target.pose.orientation
    assert (turned.x, turned.y) == (0.0, 0.0)
    assert math.degrees(2 * math.atan2(turned.z, turned.w)) == pytest.approx(90.0)


@pytest.mark.parametrize(
    ("action", "form", "fixed", "values", "said"),
    [
        (
            *(GoTo, {"target.pose.position.x": FormField(convert="yaw")}, {}),
            *({"target.pose.position.x": 90.0}, "target.pose.position.x: {x: 0.0, y: 0.0, z: 0."),
        ),
        (
            *(Haul, {"bay": FormField(convert="yaw")}, {}, {"bay": 90.0}),
            "is not a whole number",
        ),
        (
            *(GoTo, YAW, {}, {"target.pose.orientation": math.inf}),
            "target.pose.orientation: .inf is not a finite number",
        ),
        (
            *(GoTo, YAW, {}, {"target.pose.orientation": "north"}),
            "target.pose.orientation: north is not a number",
        ),
        (Haul, {}, {"bay": 2**31}, {}, "bay: 2147483648 is not within -2147483648 .. 2147483647"),
        (Haul, {}, {"bay": True}, {}, "bay: true is not a whole number"),
        (GoTo, {}, {"target.frame_id": 1}, {}, "target.frame_id: 1 is not a text"),
        (GoTo, {}, {"target.pose": {"positon": {}}}, {}, "there is no field target.pose.positon"),
        (Inspect, {}, {"labels": ["a", None]}, {}, "labels[1]: null is not a text"),
    ],
)
def test_what_does_not_fit_is_refused_with_its_path(
    action: Any, form: Any, fixed: Any, values: Any, said: str
) -> None:
    with pytest.raises(ValueError) as caught:
        goal_request(action, kind(form=form, fixed=fixed), values)
    assert said in str(caught.value)
