"""The actions that XML and YAML launch files describe: each element by its tag."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from archo_tui.launch.stand_ins import actions, ros_actions
from archo_tui.launch.stand_ins.absent import Absent, absent_class
from archo_tui.launch.stand_ins.conditions import IfCondition, UnlessCondition
from archo_tui.launch.stand_ins.core import Action, Condition, LaunchDescription, at
from archo_tui.launch.stand_ins.markup import Element, read
from archo_tui.launch.stand_ins.templates import substitutions_in, unescaped, words_in
from archo_tui.launch.stand_ins.values import ParameterFile, ParameterValue
from archo_tui.nearest import nearest_hint

_KINDS: dict[str, Any] = {kind.__name__: kind for kind in (str, bool, float, int)}
_TYPES: dict[str, Any] = {  # As a `param` names them.
    **_KINDS,
    **{f"list_of_{name}": list[kind] for name, kind in _KINDS.items()},  # type: ignore[valid-type]
    "yaml": None,
}


def load(path: str) -> LaunchDescription:
    """Return what an XML or YAML launch file describes; raise SubstitutionFailure."""
    root = read(path)
    with at(root.place):
        if root.tag != "launch":
            raise root.failure(f"it begins with {root.tag}, not launch")
        deprecated = root.get("deprecated")
        return LaunchDescription(_actions(root.others()), deprecated_reason=deprecated)


def _actions(elements: Iterable[Element]) -> list[Action]:
    return [_action(element) for element in elements]


def _action(element: Element) -> Action:
    with at(element.place):
        if element.tag not in _ACTIONS:
            near = nearest_hint(element.tag, _ACTIONS)
            raise element.failure(f"there is no action {element.tag}{near}")
        make, attributes, further = _ACTIONS[element.tag]
        options = {**_options(element, attributes), **further(element)}
        condition = _condition(element)
        try:
            action: Action = make(**options, condition=condition)
        except (TypeError, ValueError) as error:
            raise element.failure(f"{element.tag}: {error}") from None
        if not isinstance(action, Absent):
            element.check_all_asked()
        return action


def _options(element: Element, attributes: str) -> dict[str, Any]:
    """Return the options of an action that attributes give, as `option=attribute:type?` names them.

    Those that end with `?` may be missing.
    """
    found = {}
    for word in attributes.split():
        name, _, kind = word.removesuffix("?").partition(":")
        option, _, attribute = name.partition("=")
        ask = element.get if word.endswith("?") else element.need
        value = ask(attribute or option, _KINDS[kind or "str"])
        if value is not None:
            found[option] = _value(value)
    return found


def _value(given: Any) -> Any:
    """Return the value of an attribute with the substitutions in its texts."""
    if isinstance(given, list):
        return [_value(part) for part in given]
    return substitutions_in(given) if isinstance(given, str) else given


def _condition(element: Element) -> Condition | None:
    wanted, unwanted = element.get("if"), element.get("unless")
    if wanted is not None and unwanted is not None:
        raise element.failure(f"{element.tag} has if and unless: give one")
    if wanted is not None:
        return IfCondition(substitutions_in(wanted))
    return None if unwanted is None else UnlessCondition(substitutions_in(unwanted))


def _pairs(elements: Iterable[Element], key: str, value: str) -> list[tuple[Any, Any]]:
    found = []
    for element in elements:
        name, given = _value(element.need(key)), _value(element.need(value))
        element.check_all_asked()
        found.append((tuple(name), given))
    return found


def _argument(element: Element) -> dict[str, Any]:
    choices = [unescaped(choice.need("value")) for choice in element.named("choice")]
    return {
        "name": unescaped(element.need("name")),
        "description": unescaped(element.get("description") or ""),
        "choices": choices or None,
    }


def _keep(element: Element) -> dict[str, Any]:
    return {"launch_configurations": dict(_pairs(element.named("keep"), "name", "value"))}


def _group(element: Element) -> dict[str, Any]:
    return {**_keep(element), "actions": _actions(element.others("keep"))}


def _include(element: Element) -> dict[str, Any]:
    return {"launch_arguments": _pairs(element.named("arg"), "name", "value")}


def _timer(element: Element) -> dict[str, Any]:
    return {"actions": _actions(element.others())}


def _node(element: Element) -> dict[str, Any]:
    return {
        "arguments": words_in(element.get("args") or ""),
        "ros_arguments": words_in(element.get("ros_args") or ""),
        "remappings": _pairs(element.named("remap"), "from", "to"),
        "parameters": [_parameter(param) for param in element.named("param")],
        "additional_env": dict(_pairs(element.named("env"), "name", "value")),
    }


def _parameter(element: Element) -> Any:
    with at(element.place):
        source = element.get("from")
        if source is None:
            return _parameters([element])
        if element.get("name") is not None:
            raise element.failure("param has name and from: give one")
        file = ParameterFile(substitutions_in(source), **_options(element, "allow_substs:bool?"))
        element.check_all_asked()
        return file


def _parameters(elements: Iterable[Element]) -> dict[Any, Any]:
    """Return parameters by their names; nested ones are a mapping."""
    found: dict[Any, Any] = {}
    for element in elements:
        name, kind = tuple(substitutions_in(element.need("name"))), element.get("type")
        if kind is not None and kind not in _TYPES:
            near = nearest_hint(kind, _TYPES)
            raise element.failure(f"there is no type {kind}{near}: {', '.join(_TYPES)}")
        value, nested = element.get("value", object), element.named("param")
        element.check_all_asked()
        if (value is None) == (not nested):
            raise element.failure("param has either a value or further params in it")
        with at(element.place):
            one = ParameterValue(_value(value), value_type=_TYPES.get(kind or "yaml"))
            found[name] = _parameters(nested) if nested else one
    return found


_Row = tuple[Any, str, Callable[[Element], dict[str, Any]]]


def _row(make: Any, attributes: str = "", further: Any = lambda _: {}) -> _Row:
    return make, attributes, further


_NODE = (
    "executable=exec package=pkg? name? namespace? output? respawn? respawn_delay:float? "
    "cwd? prefix=launch-prefix? on_exit? exec_name? shell:bool? respawn_max_retries:int? "
    "emulate_tty:bool? sigterm_timeout:float? sigkill_timeout:float?"
)
_NAMESPACE = _row(ros_actions.PushROSNamespace, "namespace")
# By tag, the action, the attributes that are its options, and what reads further ones.
_ACTIONS: dict[str, _Row] = {
    "append_env": _row(actions.AppendEnvironmentVariable, "name value separator? prepend:bool?"),
    "arg": _row(actions.DeclareLaunchArgument, "default_value=default?", _argument),
    "executable": _row(absent_class("launch.actions", "ExecuteProcess")),
    "group": _row(actions.GroupAction, "scoped:bool? forwarding:bool?", _group),
    "include": _row(actions.IncludeLaunchDescription, "launch_description_source=file", _include),
    "let": _row(actions.SetLaunchConfiguration, "name value"),
    "load_composable_node": _row(absent_class("launch_ros.actions", "LoadComposableNodes")),
    "log": _row(actions.LogInfo, "msg=message"),
    "node": _row(ros_actions.Node, _NODE, _node),
    "node_container": _row(absent_class("launch_ros.actions", "ComposableNodeContainer")),
    "push-ros-namespace": _NAMESPACE,
    "push_ros_namespace": _NAMESPACE,
    "reset": _row(actions.ResetLaunchConfigurations, "", _keep),
    "reset_env": _row(actions.ResetEnvironment),
    "ros_timer": _row(absent_class("launch_ros.actions", "ROSTimer")),
    "set_env": _row(actions.SetEnvironmentVariable, "name value"),
    "set_parameter": _row(ros_actions.SetParameter, "name value"),
    "set_parameters_from_file": _row(ros_actions.SetParametersFromFile, "filename"),
    "set_remap": _row(ros_actions.SetRemap, "src=from dst=to"),
    "set_ros_log_dir": _row(absent_class("launch_ros.actions", "SetROSLogDir")),
    "set_use_sim_time": _row(absent_class("launch_ros.actions", "SetUseSimTime")),
    "shutdown": _row(absent_class("launch.actions", "Shutdown")),
    "timer": _row(actions.TimerAction, "period:float cancel_on_shutdown:bool?", _timer),
    "unset_env": _row(actions.UnsetEnvironmentVariable, "name"),
}
