"""The `ros2` command lines that do what the console does: to copy, and to learn from."""

from __future__ import annotations

from shlex import quote
from typing import Any

from archo_tui.robot import messages
from archo_tui.robot.values import text_of


def service_call(name: str, type_name: str, request: Any) -> str:
    """Call a service of that type with that request."""
    return f"ros2 service call {name} {type_name} {quote(messages.as_yaml(request))}"


def send_goal(name: str, type_name: str, goal: Any) -> str:
    """Send that goal to an action of that type."""
    return f"ros2 action send_goal {name} {type_name} {quote(messages.as_yaml(goal))} --feedback"


def cancel(name: str) -> str:
    """Cancel every goal of an action (an empty goal id and time mean all)."""
    return f"ros2 service call {name}/_action/cancel_goal action_msgs/srv/CancelGoal"


def set_parameter(node: str, name: str, value: Any) -> str:
    """Set one parameter."""
    return f"ros2 param set {quote(node)} {quote(name)} {quote(text_of(value))}"
