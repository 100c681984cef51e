"""What the robot's file names, against what is on the graph: only what fits is used.

ROS thread only.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rclpy.node import Node

from archo_tui.robot import forms, message_classes, messages, ros2_command
from archo_tui.robot.fields import checked, filled
from archo_tui.robot.graph import Graph
from archo_tui.robot.state import Leaf
from archo_tui.robot_file import mismatch, model


class Offers:
    """Services and actions of the robot: their classes, and why one is not used."""

    def __init__(self, node: Node, robot: model.RobotFile, graph: Graph) -> None:
        self._node, self._robot, self._graph = node, robot, graph
        made = {kind.id: _form(kind) for kind in robot.goals}
        self.forms = {name: form for name, form in made.items() if form is not None}
        self.unfit: dict[str, str] = {}  # why a goal cannot be made as the file says, by action
        for kind in robot.goals:
            if fault := _goal_fault(kind):
                self.unfit.setdefault(kind.action, fault)

    def full(self, name: str) -> str:
        """The fully qualified name of a service or action."""
        return str(self._node.resolve_service_name(name))

    def _type(self, name: str) -> str:
        """The type that the servers of a service have, empty when they have none or several."""
        full = self.full(name)
        types = self._graph.services.get(full, [])
        if len(types) > 1:  # clients are in that list too
            types = self._graph.served_types(full)
        return types[0] if len(types) == 1 else ""

    def fitting(self, name: str, values: Mapping[str, Any]) -> tuple[Any, str]:
        """Return the class of a service, when its request has exactly these fields for the values.

        Returns:
            None in place of the class where it does not fit; and why not.
        """
        full, kind = self.full(name), self._type(name)
        if not kind:
            return None, f"{full} has servers of different types: not called"
        srv_type = message_classes.load(kind)
        if srv_type is None:
            return None, mismatch.not_installed(full, kind)
        if message_classes.fields(srv_type.Request) != set(values):
            return None, f"{full} is {kind}, whose request differs: not called"
        kinds = srv_type.Request.get_fields_and_field_types()
        for field, value in values.items():
            try:
                checked(kinds[field], value, field)
            except ValueError:
                return None, f"{full} is {kind}, whose {field} is {kinds[field]}: not called"
        return srv_type, ""

    def misfits(self) -> dict[str, str]:
        """Why what is offered is not used: it is not what the robot file says."""
        found: dict[str, str] = {}
        for name, values in self._requests():
            if name in self._graph.offered and not found.get(name):
                found[name] = self.fitting(name, values)[1]
        for kind in self._robot.goals:
            types = self._graph.action_types.get(kind.action, ())
            fault = mismatch.unexpected_type(kind.action, types, (kind.type,))
            if types == (kind.type,) and message_classes.load(kind.type) is None:
                fault = mismatch.not_installed(kind.action, kind.type)
            found[kind.action] = fault or self.unfit.get(kind.action, "")
        return {name: reason for name, reason in found.items() if reason}

    def _requests(self) -> Iterator[tuple[str, Mapping[str, Any]]]:
        """Yield each service of the robot file with a request that is sent to it."""
        for command in self._robot.commands:
            yield command.service, dict.fromkeys(command.toggle, True)
        stop = self._robot.stop
        if stop is not None:
            yield stop.service, stop.request
            yield stop.release, stop.release_request

    def call_command(self, name: str, fields: Mapping[str, Any]) -> str:
        """The `ros2` command line for a call, empty when its type is not known, or another one."""
        full = self.full(name)
        types = self._graph.services.get(full, [])
        srv_type = message_classes.load(types[0]) if len(types) == 1 else None
        if srv_type is None or message_classes.fields(srv_type.Request) != set(fields):
            return ""
        try:
            request = filled(srv_type.Request(), fields)
        except ValueError:  # calling it says why
            return ""
        return ros2_command.service_call(full, types[0], request)

    def goal_command(self, kind: model.GoalKind, values: Mapping[str, Any]) -> str:
        """The `ros2` command line that sends a goal, empty when none can be made."""
        action = message_classes.load(kind.type)
        try:
            goal = None if action is None else messages.goal_request(action, kind, values)
        except ValueError:  # sending it says why
            goal = None
        if goal is None:
            return ""
        return ros2_command.send_goal(self.full(kind.action), kind.type, goal)


def _goal_fault(kind: model.GoalKind) -> str:
    """What the action's type does not have of what the robot file names, or does not take."""
    action = message_classes.load(kind.type)
    if action is None:  # said when it is on the graph
        return ""
    form = [(given.where or kind.where, path) for path, given in kind.form.items()]
    form += [(kind.where, path) for path in kind.fixed]
    said = [(kind.where, kind.message)] if kind.message else []
    left = [] if kind.remaining is None else [(kind.remaining.where, kind.remaining.field)]
    parts = (("Goal", action.Goal, form), ("Result", action.Result, said))
    for name, part, wanted in (*parts, ("Feedback", action.Feedback, left)):
        fault = mismatch.unknown_field(f"{kind.type} {name}", wanted, messages.paths(part))
        if fault:
            return fault
    return _form_fault(kind, action.Goal()) or _fixed_fault(kind, action.Goal())


def _form_fault(kind: model.GoalKind, goal: Any) -> str:
    """The first input that is not one for a field of its type."""
    types = messages.types(goal)
    for path, given in kind.form.items():
        where, said = given.where or kind.where, f"{path} is {types[path]}"
        leaf = Leaf(path, types[path], None)
        if given.convert == "yaw":
            if not {f"{path}.{axis}" for axis in "xyzw"} <= set(types):
                return f"{where}: {said}: convert: yaw is for a quaternion (x, y, z, w)"
        elif any(other.startswith(f"{path}.") for other in types):
            return f"{where}: {said}: name one of its fields"
        elif not forms.is_number(leaf) and (given.low is not None or given.high is not None):
            return f"{where}: {said}: low and high are for numbers"
    return ""


def _fixed_fault(kind: model.GoalKind, goal: Any) -> str:
    """The first fixed value that its field does not take."""
    try:
        filled(goal, kind.fixed)
    except ValueError as error:
        return f"{kind.where}: fixed: {error}"
    return ""


def _form(kind: model.GoalKind) -> tuple[Leaf, ...] | None:
    """What each field of a goal's form takes; None: its type is not installed here."""
    goal_type = message_classes.load(kind.type)
    if goal_type is None:
        return None
    types = {leaf.path: leaf for leaf in messages.leaves(goal_type.Goal())}
    turned = {path for path, given in kind.form.items() if given.convert}
    number = Leaf("", "double", 0.0)
    return tuple(
        (number if path in turned else types.get(path, number))._replace(path=path)
        for path in kind.form
    )
