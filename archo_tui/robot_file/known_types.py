"""The table of ROS interface types whose meaning is known, for a first robot file.

What a type means for a robot file is decided by this table only. Sources are the comments in the
interface files of sensor_msgs, nav_msgs, std_srvs, nav2_msgs and irobot_create_msgs.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from archo_tui.robot_file.model import (
    BatteryFields,
    FormField,
    GoalKind,
    MessageField,
    MotionFields,
    PoseFields,
    RemainingField,
    StopServices,
)

LOW = 20.0  # Percent: below it the charge of a battery is called low; our choice.

# Of sensor_msgs/msg/BatteryState: constants POWER_SUPPLY_STATUS_CHARGING and _DISCHARGING.
_CHARGING, _DISCHARGING = 1, 2


class NamedBattery(NamedTuple):
    """The fields of a general type that is a battery only if the name of its topic says so."""

    fields: BatteryFields
    words: tuple[str, ...]  # One of them is in the name of the topic.


# `percentage` is 0 to 1 by the type's comment; a robot that sends 0 to 100 is seen by its values.
BATTERIES: Mapping[str, BatteryFields] = {
    "sensor_msgs/msg/BatteryState": BatteryFields(
        percentage=MessageField("percentage", scale=100.0),
        voltage=MessageField("voltage"),
        charging=MessageField("power_supply_status", equals=_CHARGING),
        discharging=MessageField("power_supply_status", equals=_DISCHARGING),
    ),
    "archo_interfaces/msg/BatteryStatus": BatteryFields(
        percentage=MessageField("percentage"),
        voltage=MessageField("voltage"),
        charging=MessageField("is_charging"),
    ),
}
_BATTERY_WORDS = ("battery", "charge", "soc")
NAMED_BATTERIES: Mapping[str, NamedBattery] = {
    "std_msgs/msg/Float32": NamedBattery(BatteryFields(MessageField("data")), _BATTERY_WORDS),
    "std_msgs/msg/Float64": NamedBattery(BatteryFields(MessageField("data")), _BATTERY_WORDS),
}

MOTIONS: Mapping[str, MotionFields] = {
    "archo_interfaces/msg/MotorStatus": MotionFields(
        count=MessageField("encoder_ticks", unit="ticks"),
        speed=MessageField("speed", unit="m/s"),
        moving=MessageField("moving"),
        stopped=MessageField("emergency_stopped"),
    ),
    "nav_msgs/msg/Odometry": MotionFields(
        speed=MessageField("twist.twist.linear.x", unit="m/s"),
        moving=(
            MessageField("twist.twist.linear.x", beyond=0.01),
            MessageField("twist.twist.angular.z", beyond=0.02),
        ),
    ),
}

# The pose of localization is in the frame of the map; odometry drifts.
POSES: Mapping[str, PoseFields] = {
    "geometry_msgs/msg/PoseWithCovarianceStamped": PoseFields(
        x=MessageField("pose.pose.position.x"),
        y=MessageField("pose.pose.position.y"),
        orientation=MessageField("pose.pose.orientation"),
        frame=MessageField("header.frame_id"),
    ),
    "nav_msgs/msg/Odometry": PoseFields(
        x=MessageField("pose.pose.position.x"),
        y=MessageField("pose.pose.position.y"),
        orientation=MessageField("pose.pose.orientation"),
        frame=MessageField("header.frame_id"),
    ),
}
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"

READ = frozenset({*BATTERIES, *NAMED_BATTERIES, *MOTIONS, *POSES})  # Message types that are read.

# The first one that is found has its form on the screen.
GOALS: Mapping[str, GoalKind] = {
    kind.type: kind
    for kind in (
        GoalKind(
            id="navigate",
            title="Go to pose",
            noun="pose",
            action="navigate_to_pose",
            type="nav2_msgs/action/NavigateToPose",
            form={
                "pose.pose.position.x": FormField("x", unit="m"),
                "pose.pose.position.y": FormField("y", unit="m"),
                "pose.pose.orientation": FormField("yaw", -360, 360, "deg", "yaw"),
            },
            fixed={"pose.header.frame_id": "map"},
            remaining=RemainingField("distance_remaining", unit="m"),
        ),
        GoalKind(
            id="shelf",
            title="Go to shelf",
            noun="shelf",
            action="move_to_shelf",
            type="archo_interfaces/action/MoveToShelf",
            form={"shelf_number": FormField("Shelf", low=1)},
            remaining=RemainingField("distance_remaining", unit="m"),
            message="final_message",
        ),
        GoalKind("dock", "Dock", "dock", "irobot_create_msgs/action/Dock", noun="dock"),
        GoalKind("undock", "Undock", "undock", "irobot_create_msgs/action/Undock"),
    )
}

# Messages within a goal that are typed as x, y and yaw: within each, the beginning of the paths of
# position and orientation, and the path of the frame; "" for none.
GOAL_POSES: Mapping[str, tuple[str, str]] = {
    "geometry_msgs/PoseStamped": ("pose.", "header.frame_id"),
    "geometry_msgs/Pose": ("", ""),
}

# Packages of services and topics that nodes have for ROS itself; a robot file names none of them.
OF_ROS = frozenset({"lifecycle_msgs", "rcl_interfaces", "type_description_interfaces"})

INITIAL_POSE, TEXT = "geometry_msgs/msg/PoseWithCovarianceStamped", "std_msgs/msg/String"
COMMANDS = ("std_srvs/srv/Trigger", "std_srvs/srv/Empty")  # Their requests have no field.
TOGGLES: Mapping[str, str] = {"std_srvs/srv/SetBool": "data"}  # The bool of the request.

_E_STOP = "irobot_create_msgs/srv/EStop"
STOP_TYPES = frozenset({_E_STOP})  # A service of such a type is a STOP, whatever its name.
# What a service of the type sends to stop and to release, if it is a STOP.
STOPS: Mapping[str, StopServices] = {
    _E_STOP: StopServices("e_stop", {"e_stop_on": True}, "e_stop", {"e_stop_on": False}),
    "std_srvs/srv/SetBool": StopServices("", {"data": True}, "", {"data": False}),
}
# In the name of a service: a STOP, however the words are joined (`softStop`, `stopmotors`).
STOP_WORDS = ("stop", "halt", "emergency")
# As a word of its own only: "skill" is no kill switch.
STOP_WHOLE_WORDS = ("kill", "killswitch", "panic", "freeze", "abort")
RELEASE_WORDS = ("release", "reset", "clear", "unlock", "resume", "unhalt")
