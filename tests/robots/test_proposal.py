"""A robot file proposed from what was seen: which part is taken for what, and what stays open."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import get_args

import pytest

from archo_tui.robot_file.load import parse
from archo_tui.robot_file.model import DIAGNOSTICS, RobotFile
from archo_tui.robot_file.propose import Part, SeveralRobots, Sighting, propose, text_of

pytestmark = pytest.mark.pure

BATTERY = Sighting(
    "topic",
    "/tb1/battery_state",
    ("sensor_msgs/msg/BatteryState",),
    ("/tb1/base",),
    rate=1.0,
    values={"percentage": 0.75},
)
ODOMETRY = Sighting("topic", "/tb1/odom", ("nav_msgs/msg/Odometry",), ("/tb1/base",), rate=20.0)


def action(name: str, kind: str, **more: object) -> Sighting:
    return Sighting("action", name, (kind,), ("/tb1/nav",), **more)  # type: ignore[arg-type]


def service(name: str, kind: str, *nodes: str, **more: object) -> Sighting:
    return Sighting("service", name, (kind,), nodes or ("/tb1/base",), **more)  # type: ignore[arg-type]


def text(*seen: Sighting, namespace: str = "/") -> str:
    return text_of(propose(seen, namespace), "Written by a test.")


def robot(*seen: Sighting, namespace: str = "/") -> RobotFile:
    return parse(text(*seen, namespace=namespace), Path("test.yaml"))


def test_battery_and_motion_are_read_as_their_types_say() -> None:
    made = robot(BATTERY, ODOMETRY)
    assert made.name == "tb1"
    assert made.battery is not None
    assert made.battery.topic == "battery_state"
    assert made.battery.types["sensor_msgs/msg/BatteryState"].percentage.scale == 100
    assert made.motion is not None
    assert made.motion.topic == "odom"
    assert "# /tb1/odom is a nav_msgs/msg/Odometry, 20.0 Hz, published by /tb1/base" in text(
        ODOMETRY
    )


def test_every_part_that_can_be_proposed_is_read_back() -> None:
    seen = [
        BATTERY,
        ODOMETRY,
        Sighting("topic", "/tb1/diagnostics", (DIAGNOSTICS,), ("/tb1/base",), rate=1.0),
        action("/tb1/dock", "irobot_create_msgs/action/Dock"),
        service("/tb1/e_stop", "irobot_create_msgs/srv/EStop"),
        service("/tb1/lamp", "std_srvs/srv/SetBool"),
        Sighting("topic", "/tb1/initialpose", ("geometry_msgs/msg/PoseWithCovarianceStamped",), ()),
        Sighting("topic", "/tb1/words", ("std_msgs/msg/String",), ()),
    ]
    entries = propose(seen).entries
    assert {entry.part for entry in entries} == set(get_args(Part))
    not_proposed = {"version", "name", "gauges", "record", "places", "shown", "frames"}
    assert set(get_args(Part)) == {part.name for part in fields(RobotFile)} - not_proposed
    all_sure = propose(seen)._replace(entries=tuple(e._replace(is_sure=True) for e in entries))
    made = parse(text_of(all_sure, "Written by a test."), Path("test.yaml"))
    for entry in entries:
        read = getattr(made, entry.part)
        assert (
            entry.value in read
            if entry.part in ("goals", "commands", "topics")
            else entry.value == read
        )


SILENT = Sighting("topic", "/odom", ODOMETRY.types, ("/base",))
BOTH = (*ODOMETRY.types, "std_msgs/msg/Float32")
FIRST, TRIGGER, SET_BOOL = "/clearpath/base", "std_srvs/srv/Trigger", "std_srvs/srv/SetBool"


@pytest.mark.parametrize(
    ("seen", "lines"),
    [
        ([SILENT], "# /odom is a nav_msgs/msg/Odometry, no message came, published by /base"),
        (
            [replace(SILENT, values={"x": 1.0})],
            "Odometry, too few messages to tell a rate, published by /base",
        ),
        # without a subscription it is not called silent
        ([replace(SILENT, was_listened_to=False)], "Odometry, published by /base"),
        (
            [replace(SILENT, types=BOTH, rate=1.0)],
            "/odom is a nav_msgs/msg/Odometry (and of std_msgs/msg/Float32), 1.0 Hz",
        ),
        ([BATTERY], "without one, ctrl+x cancels every goal instead"),
        (
            [service("/tb1/reset_emergency_stop", TRIGGER, goal={})],
            "# Seen besides, and not described:\n#   service /tb1/reset_emergency_stop",
        ),
        (
            [service("/tb1/estop", "own_msgs/srv/Stop", goal={"engaged": "boolean"})],
            "say as `request` what is sent: engaged (boolean)",
        ),
        # a namespace that reads like a release loses no STOP
        (
            [
                service("/clearpath/emergency_stop", TRIGGER, FIRST),
                service("/clearpath/emergency_stop/reset", TRIGGER, FIRST),
            ],
            "# stop: {service: emergency_stop, release: emergency_stop/reset}",
        ),
        *(
            # a STOP gets the release that has its name and request
            (
                [
                    service("/tb1/emergency_stop", TRIGGER),
                    service("/tb1/clear_brake_stop", TRIGGER),
                    service("/tb1/reset_emergency_stop", SET_BOOL),
                    service("/tb1/halt", TRIGGER),
                ],
                lines,
            )
            for lines in (
                "# stop:\n#   service: emergency_stop\n#   release: reset_emergency_stop\n"
                "#   release_request: {data: true}\n",
                "# stop: {service: halt}",
                "#   service /tb1/clear_brake_stop: std_srvs/srv/Trigger",
            )
        ),
        (
            [Sighting("topic", f"/t{n}", ("own_msgs/msg/X",), ("/n",)) for n in range(500)],
            "#   and 300 more",
        ),
    ],
)
def test_the_text_says_what_was_seen(seen: list[Sighting], lines: str) -> None:
    assert lines in text(*seen)


def test_a_battery_that_sends_percent_is_read_as_percent() -> None:
    made = robot(BATTERY.__class__(**{**vars(BATTERY), "values": {"percentage": 87.0}}))
    assert made.battery is not None
    assert made.battery.types["sensor_msgs/msg/BatteryState"].percentage.scale == 1
    unknown = BATTERY.__class__(**{**vars(BATTERY), "values": {"percentage": float("nan")}})
    assert "its percentage is not a number" in text(unknown)
    percent = replace(unknown, types=("archo_interfaces/msg/BatteryStatus",))
    assert "its percentage is not a number" in text(percent)


def test_a_number_is_a_battery_only_by_the_name_of_its_topic() -> None:
    level = Sighting("topic", "/battery_level", ("std_msgs/msg/Float32",), ("/bat",), rate=1.0)
    assert robot(level).battery is not None
    other = Sighting("topic", "/height", ("std_msgs/msg/Float32",), ("/bat",), rate=1.0)
    assert robot(other).battery is None
    assert "#   topic /height: std_msgs/msg/Float32" in text(other)


def test_a_stop_is_never_taken_for_sure_and_never_a_command() -> None:
    seen = [
        service("/tb1/e_stop", "irobot_create_msgs/srv/EStop"),
        service("/tb1/emergency_stop", "std_srvs/srv/Trigger"),
        service("/tb1/reset_emergency_stop", "std_srvs/srv/Trigger"),
        service("/tb1/halt", "std_srvs/srv/SetBool"),
    ]
    made, written = robot(BATTERY, *seen), text(BATTERY, *seen)
    assert made.stop is None
    assert not made.commands
    assert "# stop: {service: emergency_stop, release: reset_emergency_stop}" in written
    assert "#   request: {e_stop_on: true}" in written
    assert "#   release_request: {data: false}" in written


def test_no_spelling_of_a_stop_makes_it_a_command() -> None:
    for name in (
        *("emergencyStop", "softStop", "stopmotors", "haltMotors", "E_STOP", "kill_switch"),
        *("panic", "freezeAll", "stopper/lamp"),
    ):
        stop = service(f"/tb1/{name}", TRIGGER)
        assert not robot(BATTERY, stop).commands
        assert f"# stop: {{service: {name}}}" in text(BATTERY, stop)
    assert robot(service("/tb1/skill", TRIGGER)).commands  # a word within another


def test_a_goal_that_a_robot_below_has_too_is_a_comment() -> None:
    seen = [
        service("/lamp", "std_srvs/srv/Trigger"),
        service("/tb2/lamp", "std_srvs/srv/Trigger"),
        action("/navigate_to_pose", "nav2_msgs/action/NavigateToPose"),
        action("/tb2/navigate_to_pose", "nav2_msgs/action/NavigateToPose"),
    ]
    made, written = robot(*seen), text(*seen)
    assert [goal.action for goal in made.goals] == ["navigate_to_pose"]
    assert [command.service for command in made.commands] == ["lamp"]
    assert "is it of another robot than /navigate_to_pose? Then leave it out" in written
    assert "  #   action: tb2/navigate_to_pose\n" in written


def test_commands_ask_first_since_nobody_knows_what_they_do() -> None:
    made = robot(
        service("/tb1/beep", "std_srvs/srv/Empty"),
        service("/tb1/lamp", "std_srvs/srv/SetBool"),
        service("/tb1/zero", "own_msgs/srv/Zero", goal={}),
        service("/tb1/mode", "own_msgs/srv/Mode", goal={"mode": "uint8"}),
    )
    assert {command.id: command.ask for command in made.commands} == dict.fromkeys(
        ("beep", "lamp", "zero"), "always"
    )
    lamp = next(command for command in made.commands if command.id == "lamp")
    assert lamp.toggle == {"data": "ask"}


def test_a_goal_of_an_own_type_gets_a_form_of_its_fields() -> None:
    fields = {
        "target": "geometry_msgs/PoseStamped",
        "target.header": "std_msgs/Header",
        "target.header.stamp": "builtin_interfaces/Time",
        "target.header.stamp.sec": "int32",
        "target.header.frame_id": "string",
        "target.pose": "geometry_msgs/Pose",
        "target.pose.position": "geometry_msgs/Point",
        "speed": "float",
        "timeout": "builtin_interfaces/Duration",
        "timeout.sec": "int32",
    }
    found = action(
        "/tb1/go_home",
        "own_msgs/action/GoHome",
        goal=fields,
        feedback={"left_wheel_speed": "float", "distance_left": "float"},
        result={"message": "string"},
    )
    (goal,) = robot(found).goals
    assert (goal.id, goal.title) == ("go_home", "Go home")
    assert list(goal.form) == [
        "target.pose.position.x",
        "target.pose.position.y",
        "target.pose.orientation",
        "speed",
    ]
    assert goal.remaining is not None
    assert (goal.remaining.field, goal.message) == ("distance_left", "message")


def test_of_several_poses_each_label_has_the_name_of_its_pose() -> None:
    poses = {name: "geometry_msgs/Pose" for name in ("pose", "pose.inner", "pose_behind")}
    (goal,) = robot(action("/plan", "own_msgs/action/Plan", goal=poses)).goals
    labels = [field.label for field in goal.form.values()]
    words = ("x", "y", "yaw")
    assert labels == [f"{name} {word}" for name in ("pose", "pose_behind") for word in words]


def test_a_goal_that_needs_a_list_or_an_absent_type_is_listed_only() -> None:
    path = action(
        "/tb1/follow_path",
        "nav2_msgs/action/FollowPath",
        goal={"path": "nav_msgs/Path", "path.poses": "sequence<geometry_msgs/PoseStamped>"},
    )
    other = action("/tb1/wave", "own_msgs/action/Wave")
    written = text(BATTERY, path, other)
    assert not robot(BATTERY, path, other).goals
    assert "#   action /tb1/follow_path: nav2_msgs/action/FollowPath\n" in written
    assert "#   action /tb1/wave: own_msgs/action/Wave, which is not installed here" in written


def test_two_robots_are_not_mixed() -> None:
    other = Sighting("topic", "/tb2/odom", ODOMETRY.types, ("/tb2/base",), rate=20.0)
    with pytest.raises(SeveralRobots, match="several robots are here, in /tb1, /tb2"):
        propose([BATTERY, ODOMETRY, other])
    within = robot(BATTERY, ODOMETRY, namespace="/tb1")
    assert within.motion is not None
    assert within.motion.topic == "odom"


def test_names_outside_of_the_robots_namespace_stay_whole() -> None:
    made = robot(BATTERY, service("/lamp", "std_srvs/srv/SetBool", "/lamps"))
    assert made.battery is not None
    assert made.battery.topic == "tb1/battery_state"  # Root is what both have in common.
    within = robot(BATTERY, service("/lamp", "std_srvs/srv/SetBool", "/lamps"), namespace="/tb1")
    assert within.commands[0].service == "/lamp"


def test_ids_are_never_the_consoles_own_words_or_the_same_twice() -> None:
    made = robot(
        service("/tb1/go", "std_srvs/srv/Trigger"),
        service("/tb1/a/blink", "std_srvs/srv/Trigger"),
        service("/tb1/b/blink", "std_srvs/srv/Trigger"),
    )
    assert sorted(command.id for command in made.commands) == ["blink", "blink_2", "go_2"]
