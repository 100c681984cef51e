"""The `ros2` command lines that do what the console does: to copy, and to learn from."""

from __future__ import annotations

from shlex import quote
from typing import Any

from archo_tui.robot.parameter_values import text_of


def _fields(message: Any) -> str:
    values = (
        f"{name}: {text_of(getattr(message, name))}"
        for name in message.get_fields_and_field_types()
        if name != "structure_needs_at_least_one_member"
    )
    return "{" + ", ".join(values) + "}"


def service_call(name: str, type_name: str, request: Any) -> str:
    """Call a service of that type with that request."""
    return f"ros2 service call {name} {type_name} {quote(_fields(request))}"


def send_goal(name: str, shelf: int) -> str:
    """Send a move_to_shelf goal."""
    kind = "archo_interfaces/action/MoveToShelf"
    return f"ros2 action send_goal {name} {kind} {quote(f'{{shelf_number: {shelf}}}')} --feedback"


def cancel(name: str) -> str:
    """Cancel every goal of an action (an empty goal id and time mean all)."""
    return f"ros2 service call {name}/_action/cancel_goal action_msgs/srv/CancelGoal"


def set_parameter(node: str, name: str, value: Any) -> str:
    """Set one parameter."""
    return f"ros2 param set {quote(node)} {quote(name)} {quote(text_of(value))}"
