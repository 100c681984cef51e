"""The `ros2` command lines for what the console does, to copy and to learn from.

They are "" if a request cannot be made, of which its outcome tells.
"""

from __future__ import annotations

from collections.abc import Mapping
from shlex import quote
from typing import Any

from archo_tui.robot.graph.nodes import SET, level_request
from archo_tui.robot.messages.text import as_yaml
from archo_tui.robot.messages.types import kinds, load_class
from archo_tui.robot.messages.values import filled, goal_request
from archo_tui.robot.parts import Parts
from archo_tui.robot_file.model import GoalKind
from archo_tui.yaml_text.dump import flow


def service_call(name: str, type_name: str, request: Any) -> str:
    """Return the `ros2` command line that calls a service."""
    return f"ros2 service call {name} {type_name} {quote(as_yaml(request))}"


def send_goal(name: str, type_name: str, goal: Any) -> str:
    """Return the `ros2` command line that sends a goal and prints its feedback."""
    return f"ros2 action send_goal {name} {type_name} {quote(as_yaml(goal))} --feedback"


def echo(topic: str, type_name: str) -> str:
    """Return the `ros2` command line that prints the messages of a topic of a given type."""
    return f"ros2 topic echo {quote(topic)} {quote(type_name)}"


def cancel(name: str) -> str:
    """Return the `ros2` command line that cancels every goal of an action.

    It calls the cancel service with the default request, whose zero id and time mean all goals.
    """
    return f"ros2 service call {name}/_action/cancel_goal action_msgs/srv/CancelGoal"


def change_lifecycle(node: str, word: str) -> str:
    """Return the `ros2` command line that has a managed node make a transition."""
    return f"ros2 lifecycle set {quote(node)} {quote(word)}"


def set_parameters(node: str, values: Mapping[str, Any]) -> str:
    """Return a `ros2 param set` command line for each parameter, joined by `; `."""
    if any(value == [] or _holds_bytes(value) for value in values.values()):
        return ""
    # A blank keeps `ros2` from taking a negative number for an option.
    texts = [(name, f" {flow(v)}" if flow(v)[0] == "-" else flow(v)) for name, v in values.items()]
    return "; ".join(f"ros2 param set {quote(node)} {quote(n)} {quote(text)}" for n, text in texts)


def _holds_bytes(value: Any) -> bool:
    return isinstance(value, list) and isinstance(value[0], bytes)


def cancel_all(robot: Parts) -> str:
    """Return the command lines that cancel all goals of the robot file, joined by `; `."""
    return "; ".join(cancel(robot.checks.full(kind.action)) for kind in robot.file.goals)


def service_of_file(robot: Parts, name: str, fields: Mapping[str, Any]) -> str:
    """Return the command line that calls a service of the robot file."""
    full = robot.checks.full(name)
    types = robot.graph.services.get(full, [])
    srv_type = load_class(types[0]) if len(types) == 1 else None
    if srv_type is None or kinds(srv_type.Request).keys() != fields.keys():
        return ""
    try:
        request = filled(srv_type.Request(), fields)
    except ValueError:
        return ""
    return service_call(full, types[0], request)


def goal(robot: Parts, kind: GoalKind, values: Mapping[str, Any]) -> str:
    """Return the command line that sends a goal."""
    action = load_class(kind.type)
    try:
        request = None if action is None else goal_request(action, kind, values)
    except ValueError:
        return ""
    name = robot.checks.full(kind.action)
    return "" if request is None else send_goal(name, kind.type, request)


def set_log_level(node: str, level: str) -> str:
    """Return the command line that sets the level of a node's log, one of LEVELS."""
    request = level_request(node, level)
    return service_call(f"{node}/{SET}", "rcl_interfaces/srv/SetLoggerLevels", request)
