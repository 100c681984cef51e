"""The `ros2` command lines for what the console does, to copy and to learn from."""

from __future__ import annotations

from collections.abc import Mapping
from shlex import quote
from typing import Any

from archo_tui.base.yaml_text.dump import flow
from archo_tui.robot.messages.text import as_yaml


def service_call(name: str, type_name: str, request: Any) -> str:
    """Return the `ros2` command line that calls a service."""
    return f"ros2 service call {name} {type_name} {quote(as_yaml(request))}"


def send_goal(name: str, type_name: str, goal: Any) -> str:
    """Return the `ros2` command line that sends a goal and prints its feedback."""
    return f"ros2 action send_goal {name} {type_name} {quote(as_yaml(goal))} --feedback"


def echo(topic: str, type_name: str) -> str:
    """Return the `ros2` command line that prints the messages of a topic of a given type."""
    return f"ros2 topic echo {quote(topic)} {quote(type_name)}"


def publish(topic: str, type_name: str, message: Any, rate: float, times: int | None) -> str:
    """Return the `ros2` command line that publishes a message."""
    often = "--once" if times == 1 else f"-r {rate:g}" + (f" -t {times}" if times else "")
    return f"ros2 topic pub {often} {quote(topic)} {type_name} {quote(as_yaml(message))}"


def cancel(name: str) -> str:
    """Return the `ros2` command line that cancels every goal of an action."""
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
