"""The `ros2` command lines for what the console does, to copy and to learn from."""

from __future__ import annotations

from collections.abc import Mapping
from shlex import quote
from typing import Any

from archo_tui.robot import messages
from archo_tui.yaml_text.dump import flow


def service_call(name: str, type_name: str, request: Any) -> str:
    """Return the command that calls a service of that type with that request."""
    return f"ros2 service call {name} {type_name} {quote(messages.as_yaml(request))}"


def send_goal(name: str, type_name: str, goal: Any) -> str:
    """Return the command that sends a goal to an action of that type."""
    return f"ros2 action send_goal {name} {type_name} {quote(messages.as_yaml(goal))} --feedback"


def echo(topic: str, type_name: str) -> str:
    """Return the command that prints the messages of a topic."""
    return f"ros2 topic echo {quote(topic)} {quote(type_name)}"


def cancel(name: str) -> str:
    """Return the command that cancels every goal of an action: an empty id and time mean all."""
    return f"ros2 service call {name}/_action/cancel_goal action_msgs/srv/CancelGoal"


def change_lifecycle(node: str, word: str) -> str:
    """Return the command that has a managed node make a transition."""
    return f"ros2 lifecycle set {quote(node)} {quote(word)}"


def set_parameters(node: str, values: Mapping[str, Any]) -> str:
    """Return the commands that set parameters; "" if `ros2` would guess another type for one."""
    if any(value == [] or _holds_bytes(value) for value in values.values()):
        return ""
    # A blank keeps `ros2` from taking a negative number for an option.
    texts = [(name, f" {flow(v)}" if flow(v)[0] == "-" else flow(v)) for name, v in values.items()]
    return "; ".join(f"ros2 param set {quote(node)} {quote(n)} {quote(text)}" for n, text in texts)


def _holds_bytes(value: Any) -> bool:
    return isinstance(value, list) and isinstance(value[0], bytes)
