"""The checks of the robot file's services and actions against the types on the graph."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rclpy.node import Node

from archo_tui.robot.graph.graph import Graph
from archo_tui.robot.messages import ros2_command
from archo_tui.robot.messages.text import flat_fields
from archo_tui.robot.messages.typed import is_number
from archo_tui.robot.messages.types import TypedField, field_paths, field_types, kinds, load_class
from archo_tui.robot.messages.values import filled, goal_request, put
from archo_tui.robot_file import check, model


class InterfaceChecks:
    """The comparison of the robot file's services and actions with the types that they have."""

    def __init__(self, node: Node, robot: model.RobotFile, graph: Graph) -> None:
        self._node, self._robot, self._graph = node, robot, graph
        self.forms = forms_of(robot)
        # Why the goals of an action cannot be made as the robot file says, by the action.
        self.unfit: dict[str, str] = {}
        for kind in robot.goals:
            if fault := _goal_fault(kind):
                self.unfit.setdefault(kind.action, fault)

    def full(self, name: str) -> str:
        """Return the full name of a service or an action: `/robot1/go_to` for `go_to`."""
        return str(self._node.resolve_service_name(name))

    def _type(self, name: str) -> str:
        """Return the only type of a service; "" if it is unknown, or its servers have several."""
        full = self.full(name)
        types = self._graph.services.get(full, [])
        if len(types) > 1:  # The list also has the types of clients.
            types = self._graph.served_types(full)
        return types[0] if len(types) == 1 else ""

    def request(self, name: str, values: Mapping[str, Any]) -> tuple[Any, Any, str]:
        """Return the class of a service and a request with these fields, or why none fits."""
        full, kind = self.full(name), self._type(name)
        if not kind:
            return None, None, f"{full} has servers of different types: not called"
        srv_type = load_class(kind)
        if srv_type is None:
            return None, None, check.not_installed(full, kind)
        types = kinds(srv_type.Request)
        if types.keys() != values.keys():
            return None, None, f"{full} is {kind}, whose request differs: not called"
        made = srv_type.Request()
        for field, value in values.items():
            try:
                put(made, field, value)
            except ValueError:
                fault = f"{full} is {kind}, whose {field} is {types[field]}: not called"
                return None, None, fault
        return srv_type, made, ""

    def misfits(self) -> dict[str, str]:
        """Return why services and actions are not used, by their names in the robot file."""
        found: dict[str, str] = {}
        for name, values in self._requests():
            if name in self._graph.offered and not found.get(name):
                found[name] = self.request(name, values)[2]
        for kind in self._robot.goals:
            types = self._graph.action_types.get(kind.action, ())
            fault = check.unexpected_type(kind.action, types, (kind.type,))
            if types == (kind.type,) and load_class(kind.type) is None:
                fault = check.not_installed(kind.action, kind.type)
            found[kind.action] = fault or self.unfit.get(kind.action, "")
        return {name: reason for name, reason in found.items() if reason}

    def _requests(self) -> Iterator[tuple[str, Mapping[str, Any]]]:
        """Yield each service of the robot file, with the values of a request to it."""
        for command in self._robot.commands:
            yield command.service, dict.fromkeys(command.toggle, True)
        stop = self._robot.stop
        if stop is not None:
            yield stop.service, stop.request
            yield stop.release, stop.release_request

    def cancel_commands(self) -> str:
        """Return the `ros2` command lines that cancel all goals of the robot file's actions."""
        names = [self.full(kind.action) for kind in self._robot.goals]
        return "; ".join(ros2_command.cancel(name) for name in names)

    def call_command(self, name: str, fields: Mapping[str, Any]) -> str:
        """Return the `ros2` command line that calls a service."""
        full = self.full(name)
        types = self._graph.services.get(full, [])
        # With several types the graph would be asked, on the ROS thread only.
        request = self.request(name, fields)[1] if len(types) == 1 else None
        return "" if request is None else ros2_command.service_call(full, types[0], request)

    def goal_command(self, kind: model.GoalKind, values: Mapping[str, Any]) -> str:
        """Return the `ros2` command line that sends a goal."""
        action = load_class(kind.type)
        try:
            goal = None if action is None else goal_request(action, kind, values)
        except ValueError:  # Sending the goal reports why.
            goal = None
        if goal is None:
            return ""
        return ros2_command.send_goal(self.full(kind.action), kind.type, goal)


def _goal_fault(kind: model.GoalKind) -> str:
    """Return why a goal cannot be made as the robot file says; "" if it can."""
    action = load_class(kind.type)
    if action is None:  # `misfits` reports this once the action is on the graph.
        return ""
    form = [(given.where or kind.where, path) for path, given in kind.form.items()]
    form += [(kind.where, path) for path in kind.fixed]
    message = [(kind.where, kind.message)] if kind.message else []
    remaining = [] if kind.remaining is None else [(kind.remaining.where, kind.remaining.field)]
    parts = (("Goal", action.Goal, form), ("Result", action.Result, message))
    for name, part, wanted in (*parts, ("Feedback", action.Feedback, remaining)):
        fault = check.unknown_field(f"{kind.type} {name}", wanted, field_paths(part))
        if fault:
            return fault
    return _form_fault(kind, action.Goal()) or _fixed_fault(kind, action.Goal())


def _form_fault(kind: model.GoalKind, goal: Any) -> str:
    """Return why the first unfit input of a form cannot fill its field; "" if all can."""
    types = field_types(goal)
    for path, given in kind.form.items():
        where, found = given.where or kind.where, f"{path} is {types[path]}"
        field = TypedField(path, types[path], None)
        if given.convert == "yaw":
            if not {f"{path}.{axis}" for axis in "xyzw"} <= set(types):
                return f"{where}: {found}: convert: yaw is for a quaternion (x, y, z, w)"
        elif any(other.startswith(f"{path}.") for other in types):
            return f"{where}: {found}: name one of its fields"
        elif not is_number(field) and (given.low is not None or given.high is not None):
            return f"{where}: {found}: low and high are for numbers"
    return ""


def _fixed_fault(kind: model.GoalKind, goal: Any) -> str:
    """Return why a fixed value of the robot file does not fit its field; "" if all do."""
    try:
        filled(goal, kind.fixed)
    except ValueError as error:
        return f"{kind.where}: fixed: {error}"
    return ""


def forms_of(robot: model.RobotFile) -> dict[str, tuple[TypedField, ...]]:
    """Return the fields of each goal's form, by the goal's id, where its type is installed here."""
    made = {kind.id: _form(kind) for kind in robot.goals}
    return {name: form for name, form in made.items() if form is not None}


def _form(kind: model.GoalKind) -> tuple[TypedField, ...] | None:
    """Return the fields of a goal's form; None if the action's type is not installed here."""
    goal_type = load_class(kind.type)
    if goal_type is None:
        return None
    types = {field.path: field for field in flat_fields(goal_type.Goal())}
    turned = {path for path, given in kind.form.items() if given.convert}
    number = TypedField("", "double", 0.0)
    return tuple(
        (number if path in turned else types.get(path, number))._replace(path=path)
        for path in kind.form
    )
