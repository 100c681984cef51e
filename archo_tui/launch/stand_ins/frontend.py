"""The actions that XML and YAML launch files describe: each element by its tag."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from archo_tui.launch.stand_ins import absent, actions, ros_actions
from archo_tui.launch.stand_ins.conditions import IfCondition, UnlessCondition
from archo_tui.launch.stand_ins.core import (
    Action,
    Condition,
    InvalidLaunchFileError,
    LaunchDescription,
    TextSubstitution,
    at,
)
from archo_tui.launch.stand_ins.markup import Element, read
from archo_tui.launch.stand_ins.templates import substitutions_in, unescaped, words_in
from archo_tui.launch.stand_ins.values import ParameterFile, ParameterValue
from archo_tui.nearest import nearest_hint

_TYPES: dict[str, Any] = {
    **{kind.__name__: kind for kind in (str, bool, float, int)},
    **{f"list_of_{kind.__name__}": list[kind] for kind in (str, bool, float, int)},  # type: ignore[valid-type]
    "yaml": None,
}


def load(path: str) -> LaunchDescription:
    """Return what an XML or YAML launch file describes; raise SubstitutionFailure."""
    root = read(path)
    with at(root.place):
        if root.tag != "launch":
            raise InvalidLaunchFileError(f"it begins with {root.tag}, not launch", root.place)
        deprecated = root.get("deprecated")
        return LaunchDescription(_actions(root.others()), deprecated_reason=deprecated)


def _actions(elements: Iterable[Element]) -> list[Action]:
    return [_action(element) for element in elements]


def _action(element: Element) -> Action:
    with at(element.place):
        if element.tag not in _ACTIONS:
            near = nearest_hint(element.tag, _ACTIONS)
            raise InvalidLaunchFileError(f"there is no action {element.tag}{near}", element.place)
        make, options = _ACTIONS[element.tag]
        condition = _condition(element)
        try:
            action: Action = make(**options(element), condition=condition)
        except (TypeError, ValueError) as error:
            raise InvalidLaunchFileError(f"{element.tag}: {error}", element.place) from None
        if not issubclass(make, absent.Absent):
            element.check_all_asked()
        return action


def _condition(element: Element) -> Condition | None:
    wanted, unwanted = element.get("if"), element.get("unless")
    if wanted is not None and unwanted is not None:
        raise InvalidLaunchFileError(f"{element.tag} has if and unless: give one", element.place)
    if wanted is not None:
        return IfCondition(substitutions_in(wanted))
    return None if unwanted is None else UnlessCondition(substitutions_in(unwanted))


def _text(element: Element, **names: str) -> dict[str, Any]:
    """Return options that are texts, by the attribute of each: those that are there."""
    found = {option: element.get(attribute) for option, attribute in names.items()}
    return {key: substitutions_in(text) for key, text in found.items() if text is not None}


def _needed(element: Element, **names: str) -> dict[str, Any]:
    return {key: substitutions_in(element.need(attribute)) for key, attribute in names.items()}


def _value(given: Any) -> Any:
    """Return a typed attribute with the substitutions in its texts."""
    if isinstance(given, list):
        return [_value(part) for part in given]
    if not isinstance(given, str):
        return given
    parts = substitutions_in(given)
    if len(parts) == 1 and isinstance(parts[0], TextSubstitution):
        return parts[0].text
    return parts


def _pairs(elements: Iterable[Element], key: str, value: str) -> list[tuple[Any, Any]]:
    found = []
    for element in elements:
        pair = tuple(substitutions_in(element.need(name)) for name in (key, value))
        element.check_all_asked()
        found.append(pair)
    return found  # type: ignore[return-value]


def _given(**options: Any) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


def _keep(element: Element) -> dict[Any, Any]:
    kept = _pairs(element.named("keep"), "name", "value")
    return {tuple(name): value for name, value in kept}


def _argument(element: Element) -> dict[str, Any]:
    choices = element.named("choice")
    description = element.get("description")
    return _given(
        name=unescaped(element.need("name")),
        description=None if description is None else unescaped(description),
        choices=[unescaped(choice.need("value")) for choice in choices] or None,
        **_text(element, default_value="default"),
    )


def _group(element: Element) -> dict[str, Any]:
    return _given(
        scoped=element.get("scoped", bool),
        forwarding=element.get("forwarding", bool),
        launch_configurations=_keep(element) or None,
        actions=_actions(element.others("keep")),
    )


def _include(element: Element) -> dict[str, Any]:
    arguments = _pairs(element.named("arg"), "name", "value")
    source = substitutions_in(element.need("file"))
    return {"launch_description_source": source, "launch_arguments": arguments}


def _timer(element: Element) -> dict[str, Any]:
    return _given(
        period=_value(element.need("period", float)),
        cancel_on_shutdown=_value(element.get("cancel_on_shutdown", bool)),
        actions=_actions(element.others()),
    )


def _append(element: Element) -> dict[str, Any]:
    return _given(
        prepend=_value(element.get("prepend", bool)),
        **_needed(element, name="name", value="value"),
        **_text(element, separator="separator"),
    )


def _node(element: Element) -> dict[str, Any]:
    args, ros_args = element.get("args"), element.get("ros_args")
    delay = element.get("respawn_delay", float)
    if isinstance(delay, str) or (delay is not None and delay < 0):
        raise InvalidLaunchFileError(f"respawn_delay={delay!r}: seconds are wanted", element.place)
    environment = _pairs(element.named("env"), "name", "value")
    parameters = [_parameter(param) for param in element.named("param")]
    return _given(
        arguments=None if args is None else words_in(args),
        ros_arguments=None if ros_args is None else words_in(ros_args),
        respawn_delay=delay,
        remappings=_pairs(element.named("remap"), "from", "to"),
        parameters=parameters or None,
        additional_env={tuple(name): value for name, value in environment},
        **_needed(element, executable="exec"),
        **_text(element, package="pkg", name="name", namespace="namespace", output="output"),
        **_text(element, respawn="respawn", cwd="cwd", prefix="launch-prefix", on_exit="on_exit"),
        **_text(element, exec_name="exec_name"),
        shell=element.get("shell", bool),
        respawn_max_retries=element.get("respawn_max_retries", int),
        emulate_tty=element.get("emulate_tty", bool),
        sigterm_timeout=element.get("sigterm_timeout", float),
        sigkill_timeout=element.get("sigkill_timeout", float),
    )


def _parameter(element: Element) -> Any:
    with at(element.place):
        source = element.get("from")
        if source is None:
            return _parameters([element])
        if element.get("name") is not None:
            raise InvalidLaunchFileError("param has name and from: give one", element.place)
        has_substitutions = _value(element.get("allow_substs", bool)) or False
        element.check_all_asked()
        return ParameterFile(substitutions_in(source), allow_substs=has_substitutions)


def _parameters(elements: Iterable[Element]) -> dict[Any, Any]:
    """Return parameters by their names; nested ones are a mapping."""
    found: dict[Any, Any] = {}
    for element in elements:
        name = tuple(substitutions_in(element.need("name")))
        kind = element.get("type")
        if kind is not None and kind not in _TYPES:
            text = f"there is no type {kind}{nearest_hint(kind, _TYPES)}: {', '.join(_TYPES)}"
            raise InvalidLaunchFileError(text, element.place)
        value = element.get("value", _TYPES.get(kind))
        nested = element.named("param")
        element.check_all_asked()
        if (value is None) == (not nested):
            text = "param has either a value or further params in it"
            raise InvalidLaunchFileError(text, element.place)
        with at(element.place):
            found[name] = (
                _parameters(nested)
                if nested
                else ParameterValue(_value(value), value_type=_TYPES.get(kind))
            )
    return found


def _nothing(_element: Element) -> dict[str, Any]:
    return {}


def _texts(**names: str) -> Callable[[Element], dict[str, Any]]:
    """Return what reads the options of an action whose options are texts that it needs."""
    return lambda element: _needed(element, **names)


def _absent(module: str, name: str) -> tuple[Any, Callable[[Element], dict[str, Any]]]:
    return absent.absent_class(module, name), _nothing


_NAMESPACE = ros_actions.PushROSNamespace, _texts(namespace="namespace")
# By tag, the action, and what reads its options.
_ACTIONS: dict[str, tuple[Any, Callable[[Element], dict[str, Any]]]] = {
    "append_env": (actions.AppendEnvironmentVariable, _append),
    "arg": (actions.DeclareLaunchArgument, _argument),
    "executable": _absent("launch.actions", "ExecuteProcess"),
    "group": (actions.GroupAction, _group),
    "include": (actions.IncludeLaunchDescription, _include),
    "let": (actions.SetLaunchConfiguration, _texts(name="name", value="value")),
    "load_composable_node": _absent("launch_ros.actions", "LoadComposableNodes"),
    "log": (actions.LogInfo, _texts(msg="message")),
    "node": (ros_actions.Node, _node),
    "node_container": _absent("launch_ros.actions", "ComposableNodeContainer"),
    "push-ros-namespace": _NAMESPACE,
    "push_ros_namespace": _NAMESPACE,
    "reset": (
        actions.ResetLaunchConfigurations,
        lambda element: {"launch_configurations": _keep(element)},
    ),
    "reset_env": (actions.ResetEnvironment, _nothing),
    "ros_timer": _absent("launch_ros.actions", "ROSTimer"),
    "set_env": (actions.SetEnvironmentVariable, _texts(name="name", value="value")),
    "set_parameter": (ros_actions.SetParameter, _texts(name="name", value="value")),
    "set_parameters_from_file": (
        ros_actions.SetParametersFromFile,
        _texts(filename="filename"),
    ),
    "set_remap": (ros_actions.SetRemap, _texts(src="from", dst="to")),
    "set_ros_log_dir": _absent("launch_ros.actions", "SetROSLogDir"),
    "set_use_sim_time": _absent("launch_ros.actions", "SetUseSimTime"),
    "shutdown": _absent("launch.actions", "Shutdown"),
    "timer": (actions.TimerAction, _timer),
    "unset_env": (actions.UnsetEnvironmentVariable, _texts(name="name")),
}
