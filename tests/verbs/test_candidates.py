"""The words that a shell offers at a tab, of what a console knows."""

from __future__ import annotations

from typing import Any

import pytest

from archo_tui.robot.state.graph import Parameter
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.verbs import verbs
from archo_tui.verbs.verb import candidates
from tests.support.states import NORMAL
from tests.support.stub import StubRobot, stub_station

KNOWN = NORMAL._replace(
    parameters=(*NORMAL.parameters, Parameter("/dashboard", "quiet", "bool", False, False)),
    services={"/reset_encoder": ("archo_interfaces/srv/ResetEncoder",)},
    actions={"/move_to_shelf": ("archo_interfaces/action/MoveToShelf",)},
)
SHELVES = Parameter("/motor_controller", "shelf_count", "integer", 12, 12)


def offered(*words: str, snapshot: Snapshot = KNOWN) -> list[str]:
    """Return what is offered for the last word."""
    robot: Any = StubRobot(snapshot)
    station = stub_station(robot)
    station.on_snapshot(snapshot)
    return candidates(verbs(snapshot.file, snapshot.forms), station, words)


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (("st",), ["stop", "status", "start"]),
        (("set", "motor"), ["motor_controller"]),
        (("set", "/motor"), ["/motor_controller"]),
        (("get", "motor_controller", "max"), ["max_speed"]),
        (("get", "motor_controller", "max_speed", ""), []),
        (("get", "nobody", ""), []),
        (("set", "max"), ["max_speed"]),
        (("set", "quiet", ""), ["false", "true"]),
        (("set", "dashboard", "quiet", ""), ["false", "true"]),
        (("echo", "bat"), ["battery_drain", "battery_level"]),
        (("hz", "/mot"), ["/motor_status"]),
        (("call", "re"), ["reset_encoder"]),
        (("send_goal", ""), ["move_to_shelf"]),
        (("interface", "std_msgs"), ["std_msgs/msg/Float32"]),
        (("log_level", "motor_controller", "wa"), ["warn"]),
        (("lifecycle", "any", "act"), ["activate"]),
        (("wait", "i"), ["idle"]),
        (("stop", ""), []),
        (("cancel", "--a"), ["--all"]),
        (("jump", ""), []),
    ],
)
def test_a_word_is_offered_that_the_console_would_take(
    words: tuple[str, ...], wanted: list[str]
) -> None:
    assert offered(*words) == wanted


def test_the_shelves_are_offered_that_the_robot_reports() -> None:
    shelves = NORMAL._replace(parameters=(SHELVES,))
    assert offered("go", "", snapshot=shelves) == [str(shelf) for shelf in range(1, 13)]
    assert offered("go", "12", "1", snapshot=shelves) == ["1", "10", "11", "12"]
    assert offered("go", "13", snapshot=shelves) == []
    assert offered("go", "", snapshot=NORMAL._replace(parameters=())) == []
