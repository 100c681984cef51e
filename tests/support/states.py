"""Every state that a panel can be in, by name."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from archo_tui.robot.messages.period import MessageRate
from archo_tui.robot.state.events import Event
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.graph import NodeState, Parameter, Resource
from archo_tui.robot.state.readings import Battery, Motion
from archo_tui.robot.state.snapshot import OpenStop, Snapshot
from archo_tui.text.state import Spans
from tests.support.archo import ARCHO, FORMS, SHELF
from tests.support.clock import NOW, TIME

ALL = frozenset(
    {
        "battery_level",
        "motor_status",
        "reset_encoder",
        "emergency_stop",
        "release_emergency_stop",
        "set_charging",
        "move_to_shelf",
    }
)

MOVING = Goal(
    kind=SHELF,
    fields={"shelf_number": 12},
    phase=Phase.MOVING,
    sent=NOW - 1.6,
    time=TIME - 1.5,
    length=18.0,
    remaining=9.0,
    heard=NOW,
    started=NOW - 1.5,
    way=((NOW - 1.5, 18.0), (NOW - 0.75, 13.5), (NOW, 9.0)),
)


def ended(shelf: int, phase: Phase, message: str, remaining: float = 0.0) -> Goal:
    return MOVING._replace(
        number=shelf,
        fields={"shelf_number": shelf},
        phase=phase,
        message=message,
        remaining=remaining,
        ended=NOW + 1.5,
    )


ARRIVED = ended(12, Phase.ARRIVED, "Arrived at shelf 12")
CANCELLED = ended(3, Phase.CANCELLED, "Cancelled mid-route", 9.0)
BATTERY = Battery(87.5, 24.1, False, "good", NOW - 0.4)
MOTOR = Motion(15420, 0.0, False, False, NOW - 0.1)
PARAMETERS = (
    Parameter("/battery_monitor", "low_battery_threshold", "double", 20.0, 20.0, "%", 0, 100),
    Parameter("/battery_monitor", "publish_period", "double", 1.0, 1.0, "s", 0.02, 10),
    Parameter("/motor_controller", "max_speed", "double", 0.5, 0.8, "m/s", 0.05, 2.0),
    Parameter("/motor_controller", "wheel_radius", "double", 0.05, 0.05, "m", 0.01, 0.5),
    Parameter(
        "/motor_controller", "ticks_per_revolution", "integer", 1024, 1024, "", read_only=True
    ),
)
EVENTS = (
    Event(TIME - 40, "ERROR", "motor_controller", "max_speed 9 refused: allowed 0.05 .. 2"),
    Event(
        TIME - 2,
        "YOU",
        "console",
        "go to shelf 12: accepted",
        "ros2 action send_goal /move_to_shelf archo_interfaces/action/MoveToShelf",
    ),
    Event(TIME - 1, "WARN", "dashboard", "Low battery: 18.0%", count=12, first=TIME - 60),
)
RESOURCES = tuple(
    Resource(kind, name, (type_name,), tuple(nodes))
    for kind, name, type_name, *nodes in (
        ("topic", "/battery_drain", "std_msgs/msg/Float32"),
        ("topic", "/battery_level", "archo_interfaces/msg/BatteryStatus", "/battery_monitor"),
        ("topic", "/motor_status", "archo_interfaces/msg/MotorStatus", "/motor_controller"),
        ("service", "/emergency_stop", "archo_interfaces/srv/EmergencyStop", "/motor_controller"),
        ("service", "/release_emergency_stop", "std_srvs/srv/Trigger", "/motor_controller"),
        ("service", "/reset_encoder", "archo_interfaces/srv/ResetEncoder", "/motor_controller"),
        ("service", "/set_charging", "std_srvs/srv/SetBool", "/battery_monitor"),
        ("action", "/move_to_shelf", "archo_interfaces/action/MoveToShelf", "/motor_controller"),
    )
)
CHARGE = tuple((NOW - 170 + second, 87.5 + (170 - second) / 10) for second in range(171))
NORMAL = Snapshot(
    file=ARCHO,
    forms=FORMS,
    battery=BATTERY,
    charge=CHARGE,
    motion=MOTOR,
    parameters=PARAMETERS,
    nodes=(
        NodeState("/battery_monitor", NOW - 0.4, 1.0),
        NodeState("/dashboard", NOW - 0.4),
        NodeState("/motor_controller", NOW - 0.1, 5.0),
    ),
    offered=ALL,
    events=EVENTS,
    resources=RESOURCES,
    message_rates={
        "/battery_level": MessageRate(NOW - 0.4, 1.0),
        "/motor_status": MessageRate(NOW - 0.1, 0.2),
    },
)


def past(seconds: int) -> Iterator[tuple[Snapshot, float]]:
    """Each second that led to NORMAL: a battery that falls, two moves of a minute."""
    for ago in range(seconds, -1, -1):
        now = NOW - ago
        moves = 400 < ago <= 460 or 100 < ago <= 160
        left = 18.0 * ((ago - 100) % 300) / 60
        yield (
            NORMAL._replace(
                battery=BATTERY._replace(percentage=87.5 - (600 - ago) / 9, received=now),
                motion=replace(MOTOR, speed=0.8 if moves else 0.0, received=now),
                goal=MOVING._replace(remaining=left) if moves else None,
            ),
            now,
        )


def goal(phase: Phase, **changes: object) -> Snapshot:
    return NORMAL._replace(
        goal=MOVING._replace(phase=phase, **changes),  # type: ignore[arg-type]
        history=(ARRIVED, CANCELLED),
    )


def battery(percentage: float | None = 87.5, **changes: object) -> Snapshot:
    return NORMAL._replace(battery=BATTERY._replace(percentage=percentage, **changes))  # type: ignore[arg-type]


STATES: dict[str, Snapshot] = {
    "nothing heard yet": Snapshot(file=ARCHO, forms=FORMS),
    "normal": NORMAL,
    "battery low and moving": goal(Phase.MOVING)._replace(
        battery=BATTERY._replace(percentage=18.0, voltage=21.3, health="warning"),
    ),
    "battery empty": battery(0.0, voltage=20.6, health="warning"),
    "battery charging": battery(43.0, voltage=22.3, charging=True)._replace(
        charge=tuple((NOW - 60 + second, 13.0 + second / 2) for second in range(61)),
    ),
    "battery to be replaced": battery(87.5, health="replace"),
    "battery without health": battery(18.0, voltage=None, health=None, charging=None),
    "battery not a number": NORMAL._replace(
        battery=BATTERY._replace(percentage=None, voltage=None, unreadable="nan")
    ),
    "battery of another type": NORMAL._replace(
        battery=Battery(),
        faults={
            "battery_level": "battery_level is std_msgs/msg/String: expected "
            "archo_interfaces/msg/BatteryStatus or std_msgs/msg/Float32",
            "emergency_stop": "/emergency_stop is std_srvs/srv/SetBool, whose request is another: "
            "not called",
            "move_to_shelf": "move_to_shelf is example_interfaces/action/Fibonacci: expected "
            "archo_interfaces/action/MoveToShelf",
        },
    ),
    "battery with an unknown word": battery(87.5, health="swollen"),
    "battery published twice": NORMAL._replace(
        publishers={"battery_level": ("/battery_monitor", "/battery_monitor_2")}
    ),
    "battery old": battery(87.5, received=NOW - 4.2),
    "contact lost": goal(Phase.LOST, heard=NOW - 9.0)._replace(
        battery=BATTERY._replace(received=NOW - 9.5),
        motion=replace(MOTOR, received=NOW - 9.1),
        nodes=tuple(node._replace(heard=NOW - 9.1) for node in NORMAL.nodes),
        message_rates={
            name: rate._replace(heard=NOW - 9.1) for name, rate in NORMAL.message_rates.items()
        },
    ),
    "motor moving": goal(Phase.MOVING)._replace(
        motion=Motion(1_234_567, 0.8, True, False, NOW - 0.1)
    ),
    "motor stopped": goal(
        Phase.ABORTED, message="Emergency stop, 9.0 m before shelf 12", ended=NOW
    )._replace(
        motion=replace(MOTOR, stopped=True),
    ),
    "goal sent": goal(Phase.SENT, started=None, heard=None, remaining=None),
    "goal refused": goal(
        Phase.REFUSED, message="shelf 99 is not in 1 .. 40", fields={"shelf_number": 99}
    ),
    "goal cancelling": goal(Phase.CANCELLING, cancel_asked=NOW - 0.4),
    "goal cancelled": NORMAL._replace(goal=CANCELLED, history=(CANCELLED,)),
    "goal arrived": NORMAL._replace(goal=ARRIVED, history=(ARRIVED, CANCELLED)),
    "goal unknown": goal(Phase.UNKNOWN, started=None, heard=None, remaining=None),
    "motor stop not confirmed": NORMAL._replace(open_stop=OpenStop(NOW - 2.0)),
    "node silent": NORMAL._replace(
        nodes=(NORMAL.nodes[0]._replace(heard=NOW - 4.0), *NORMAL.nodes[1:])
    ),
    "many parameters": NORMAL._replace(
        parameters=tuple(
            Parameter(f"/guest_{n // 20}", f"gain_{n}", "double", n + 0.5, n + 0.5)
            for n in range(10_000)
        ),
    ),
    "nothing offered": NORMAL._replace(offered=frozenset(), nodes=(), resources=()),
}


def board(shelves: Any, of: Snapshot = NORMAL) -> Snapshot:
    """The same of a robot that says how many shelves it has."""
    node, name = "/motor_controller", "shelf_count"
    count = Parameter(node, name, "integer", shelves, shelves, "shelves are 1 .. this", 1, 9999)
    return of._replace(parameters=(*of.parameters, count))


def plain_text(spans: Spans) -> str:
    """The text of spans without their tones."""
    return "".join(text for text, _ in spans)
