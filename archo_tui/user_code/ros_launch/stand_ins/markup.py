"""XML and YAML launch files: a tree of elements, texts with `$(name ARGUMENT ...)`, actions."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterable
from dataclasses import MISSING, dataclass, field, fields
from pathlib import Path
from typing import Any
from xml.parsers import expat

import yaml

from archo_tui.base import regular_files
from archo_tui.base.nearest import nearest_hint
from archo_tui.base.yaml_text import bounded_yaml
from archo_tui.base.yaml_text.core_schema import YamlFault
from archo_tui.user_code.ros_launch.stand_ins import actions, ros_actions, substitutions
from archo_tui.user_code.ros_launch.stand_ins.core import (
    Action,
    Condition,
    LaunchDescription,
    Place,
    Substitution,
    SubstitutionFailure,
    TextSubstitution,
    at,
    calling_place,
)
from archo_tui.user_code.ros_launch.stand_ins.modules import Absent, absent_class
from archo_tui.user_code.ros_launch.stand_ins.packages import FindPackagePrefix, FindPackageShare

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")
_DOLLAR = r"\$(?!\()|(?<=\\)\$"  # One that begins no substitution.
# What texts consist of besides substitutions: at the top, without quotes, in single, in double.
_TEXT = re.compile(rf"(?:[^$]|{_DOLLAR})+")
_WORD = re.compile(rf"""(?:[^ $()\\'"]|{_DOLLAR}|\\.?)+""")
_QUOTED = {quote: re.compile(rf"(?:[^$\\{quote}]|{_DOLLAR}|\\.?)+") for quote in "'\""}

# Each substitution by its name; its arguments are the fields of the class.
_SUBSTITUTIONS: dict[str, Any] = {
    **{name: absent_class(name) for name in ("command", "exec-in-pkg", "find-exec")},
    "and": substitutions.AndSubstitution,
    "dirname": substitutions.ThisLaunchFileDir,
    "env": substitutions.EnvironmentVariable,
    "equals": substitutions.EqualsSubstitution,
    "eval": substitutions.PythonExpression,
    "file-content": substitutions.FileContent,
    "filename": substitutions.ThisLaunchFile,
    "find-pkg-prefix": FindPackagePrefix,
    "find-pkg-share": FindPackageShare,
    "if": substitutions.IfElseSubstitution,
    "not": substitutions.NotSubstitution,
    "not-equals": substitutions.NotEqualsSubstitution,
    "or": substitutions.OrSubstitution,
    "var": substitutions.LaunchConfiguration,
}

_YAML: Any = yaml.constructor.SafeConstructor()  # Of YAML 1.1, by which launch reads values.
_KINDS: dict[str, Any] = {kind.__name__: kind for kind in (str, bool, float, int)}
_TYPES: dict[str, Any] = {  # As a `param` names them.
    **_KINDS,
    **{f"list_of_{name}": list[kind] for name, kind in _KINDS.items()},  # type: ignore[valid-type]
    "yaml": None,
}
# The attributes that need not be texts in YAML.
_NO_TEXTS = {
    *("allow_substs", "cancel_on_shutdown", "emulate_tty", "forwarding", "period", "prepend"),
    *("respawn_delay", "respawn_max_retries", "scoped", "shell"),
    *("sigkill_timeout", "sigterm_timeout"),
}


@dataclass
class _Element:
    """An element of a launch file, with texts as attributes, or values of YAML."""

    tag: str
    place: Place
    attributes: dict[str, Any] = field(default_factory=dict)
    elements: list[_Element] = field(default_factory=list)

    def get(self, name: str) -> Any:
        """Return an attribute; None if there is none."""
        value = self.attributes.get(name)
        if value is None or isinstance(value, str) or name in _NO_TEXTS:
            return value
        raise self.failure(f'{name} of {self.tag}: a text is wanted: "{str(value).lower()}"')

    def need(self, name: str) -> Any:
        """Return an attribute that must be there."""
        value = self.get(name)
        if value is None:
            raise self.failure(f"{self.tag} has no {name}{nearest_hint(name, self.attributes)}")
        return value

    def check_names(self, attributes: Iterable[str], tags: Iterable[str] = ()) -> None:
        """Raise SubstitutionFailure for an attribute or a sub-element of another name."""
        for name in [*self.attributes, *(part.tag for part in self.elements)]:
            if name in self.attributes and name in tags:
                raise self.failure(
                    f"{name} of {self.tag}: a list is wanted, as `{name}: [{{...}}]`"
                )
            if name not in (known := [*attributes, *tags]):
                raise self.failure(f"{self.tag} takes no {name}{nearest_hint(name, known)}")

    def failure(self, text: str) -> SubstitutionFailure:
        return SubstitutionFailure(text, self.place)


def _read_xml(path: str) -> _Element:
    """Read an XML file. Entities are refused: a few can expand to gigabytes."""
    parser, open_ = expat.ParserCreate(), [_Element("", Place(path, 1))]

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = _Element(tag, Place(path, parser.CurrentLineNumber), attributes)
        open_[-1].elements.append(element)
        open_.append(element)

    def refuse(name: str, *_: object) -> None:
        place = Place(path, parser.CurrentLineNumber)
        raise SubstitutionFailure(f"entities (&{name};) are not read: write it out", place)

    parser.StartElementHandler, parser.EntityDeclHandler = start, refuse
    parser.EndElementHandler = lambda _: open_.pop()
    try:
        parser.Parse(regular_files.read(Path(path)), True)
    except expat.ExpatError as error:
        why = f"not XML: {expat.ErrorString(error.code)}"
        raise SubstitutionFailure(why, Place(path, error.lineno)) from None
    except (LookupError, ValueError) as error:  # As for `encoding="none such"`.
        raise SubstitutionFailure(f"not XML: {error}", Place(path, 1)) from None
    return open_[0].elements[0]


def _read_yaml(path: str) -> _Element:
    try:
        text = bounded_yaml.read(Path(path))
        bounded_yaml.node_of(text)  # Raises for what never ends, or is no YAML.
    except YamlFault as fault:
        raise SubstitutionFailure(fault.reason, Place(path, fault.line)) from None
    except bounded_yaml.YamlError as error:  # It cannot be read; its text begins with the file.
        why = str(error).removeprefix(f"{path}:").strip()
        raise SubstitutionFailure(why, Place(path, 0)) from None
    return _yaml_element(path, yaml.compose(text, Loader=yaml.SafeLoader))


def _yaml_element(path: str, node: yaml.Node | None) -> _Element:
    """Return the element of a mapping from its tag alone to what it contains."""
    if not isinstance(node, yaml.MappingNode) or len(node.value) != 1:
        place = Place(path, node.start_mark.line + 1 if node else 1)
        raise SubstitutionFailure("each entry is one action, as `- node:`", place)
    [(key, content)] = node.value
    return _yaml_content(path, key, content)


def _yaml_content(path: str, key: yaml.Node, node: yaml.Node) -> _Element:
    element = _Element(str(key.value), Place(path, key.start_mark.line + 1))
    if isinstance(node, yaml.SequenceNode):
        element.elements = [_yaml_element(path, part) for part in node.value]
    elif isinstance(node, yaml.MappingNode):
        for name, content in node.value:
            parts = content.value if isinstance(content, yaml.SequenceNode) else []
            if name.value == "children" and isinstance(content, yaml.SequenceNode):
                element.elements += [_yaml_element(path, part) for part in parts]
            elif parts and all(isinstance(part, yaml.MappingNode) for part in parts):
                element.elements += [_yaml_content(path, name, part) for part in parts]
            else:
                element.attributes[name.value] = _YAML.construct_document(content)
    else:
        raise element.failure(f"{element.tag}: a mapping or a list is wanted")
    return element


def substitutions_in(text: str) -> list[Substitution]:
    """Return the substitutions of a text, and the texts between them; raise SubstitutionFailure."""
    return _parts(text, 0, _TEXT)[0] or [TextSubstitution(text="")]


def words_in(text: str) -> list[list[Substitution]]:
    """Return the words of a command line, each with its substitutions, as a shell splits them."""
    words: list[list[Substitution]] = [[]]
    for part in substitutions_in(text):
        if not isinstance(part, TextSubstitution):
            words[-1].append(part)
            continue
        for number, word in enumerate(shlex.split(part.text)):
            if number or part.text[0].isspace():
                words.append([])
            words[-1].append(TextSubstitution(text=word))
        if part.text[-1:].isspace():
            words.append([])
    return [word for word in words if word]


def unescaped(text: str) -> str:
    """Return a text without the backslash before each character."""
    return re.sub(r"\\(.)", r"\1", text)


def _parts(text: str, at: int, of: re.Pattern[str]) -> tuple[list[Substitution], int]:
    """Read texts of a pattern and substitutions, as many as there are; return where they end."""
    found: list[Substitution] = []
    while at < len(text):
        if text.startswith("$(", at):
            part, at = _substitution(text, at)
            found.append(part)
        elif (match := of.match(text, at)) is not None:
            found.append(TextSubstitution(text=unescaped(match[0])))
            at = match.end()
        else:
            break
    return found, at


def _substitution(text: str, begin: int) -> tuple[Substitution, int]:
    """Read `$(name ARGUMENT ...)`; return where it ends."""

    def failure(why: str) -> SubstitutionFailure:
        return SubstitutionFailure(f"{text[begin:]}: {why}", calling_place())

    match, arguments = _NAME.match(text, begin + 2), []
    if match is None or match[0] not in _SUBSTITUTIONS:
        near = nearest_hint(match[0], _SUBSTITUTIONS) if match else ""
        raise failure(f"there is no such substitution{near}")
    name, at = match[0], match.end()
    while text.startswith(" ", at):
        quote, at = text[at + 1 : at + 2], at + 1
        is_quoted = quote in _QUOTED
        argument, end = _parts(text, at + is_quoted, _QUOTED[quote] if is_quoted else _WORD)
        if end == at:
            raise failure("one blank is wanted between its words")
        if is_quoted and not text.startswith(quote, end):
            raise failure(f"its {quote} is not closed")
        arguments.append(argument)
        at = end + is_quoted
    if not text.startswith(")", at):
        raise failure(f"a blank or ) is wanted before {text[at:]!r}, or quotes")
    make: Callable[..., Substitution] = _SUBSTITUTIONS[name]
    if issubclass(_SUBSTITUTIONS[name], Absent):
        return make(), at + 1
    takes = fields(_SUBSTITUTIONS[name])
    needed = [field for field in takes if field.default is MISSING]
    if not len(needed) <= len(arguments) <= len(takes):
        wanted = " ".join([name, *(field.name.upper() for field in takes)])
        raise failure(f"it is written $({wanted})")
    given = zip(takes, arguments, strict=False)
    return make(**{field.name: argument for field, argument in given}), at + 1


def _load(read: Callable[[str], _Element]) -> Callable[[str], LaunchDescription]:
    def load(path: str) -> LaunchDescription:
        root = read(path)
        if root.tag != "launch":
            raise root.failure(f"it begins with {root.tag}, not launch")
        return LaunchDescription(map(_action, root.elements))

    return load


def _action(element: _Element) -> Action:
    with at(element.place):
        if element.tag not in _ACTIONS:
            near = nearest_hint(element.tag, _ACTIONS)
            raise element.failure(f"there is no action {element.tag}{near}")
        make, names, *tags = _ACTIONS[element.tag]
        if not names and not tags:
            return make(condition=_condition(element))  # type: ignore[no-any-return]
        options = _options(element, names)
        for tag in tags:
            inside = [part for part in element.elements if part.tag == tag]
            if tag == "*":
                inside = [part for part in element.elements if part.tag not in tags]
            option, value_of = _PARTS[tag]
            options[option] = value_of(inside)
        known = [word.partition("=")[2] or word for word in names.replace("?", "").split()]
        parts = [part.tag for part in element.elements] if "*" in tags else tags
        element.check_names([*known, "if", "unless"], parts)
        try:
            action: Action = make(**options, condition=_condition(element))
        except (TypeError, ValueError) as error:
            raise element.failure(f"{element.tag}: {error}") from None
        return action


def _options(element: _Element, names: str) -> dict[str, Any]:
    """Return the options that attributes give, as `option=attribute` names them; `?` may miss."""
    found = {}
    for word in names.split():
        option, _, attribute = word.removesuffix("?").partition("=")
        name = attribute or option
        value = element.get(name) if word.endswith("?") else element.need(name)
        if value is not None:
            read: Any = _READERS.get((element.tag, name), _value)
            found[option] = read(value)
    return found


def _value(given: Any) -> Any:
    """Return the value of an attribute with the substitutions in its texts."""
    if isinstance(given, list):
        return [_value(part) for part in given]
    return substitutions_in(given) if isinstance(given, str) else given


def _condition(element: _Element) -> Condition | None:
    wanted, unwanted = element.get("if"), element.get("unless")
    if wanted is not None and unwanted is not None:
        raise element.failure(f"{element.tag} has if and unless: give one")
    if wanted is not None:
        return actions.IfCondition(substitutions_in(wanted))
    return None if unwanted is None else actions.UnlessCondition(substitutions_in(unwanted))


def _pairs(elements: Iterable[_Element], key: str = "name", value: str = "value") -> list[Any]:
    for element in elements:
        element.check_names([key, value])
    return [(tuple(_value(e.need(key))), _value(e.need(value))) for e in elements]


def _parameter(element: _Element) -> Any:
    if element.get("from") is None:
        return _parameters([element])
    with at(element.place):
        element.check_names(["from", "allow_substs"])
        return ros_actions.ParameterFile(**_options(element, "param_file=from allow_substs?"))


def _parameters(elements: Iterable[_Element]) -> dict[Any, Any]:
    """Return parameters by their names; nested ones are a mapping."""
    found: dict[Any, Any] = {}
    for element in elements:
        element.check_names(["name", "type", "value"], ["param"])
        name, kind = tuple(substitutions_in(element.need("name"))), element.get("type")
        if kind is not None and kind not in _TYPES:
            near = nearest_hint(kind, _TYPES)
            raise element.failure(f"there is no type {kind}{near}: {', '.join(_TYPES)}")
        value = element.attributes.get("value")
        if (value is None) == (not element.elements):
            raise element.failure("param has either a value or further params in it")
        with at(element.place):
            one = ros_actions.ParameterValue(_value(value), value_type=_TYPES.get(kind or "yaml"))
            found[name] = _parameters(element.elements) if element.elements else one
    return found


# How an attribute is read that is no text with substitutions.
_READERS: dict[tuple[str, str], Callable[[str], Any]] = {
    ("arg", "name"): unescaped,
    ("arg", "description"): unescaped,
    ("node", "args"): words_in,
    ("node", "ros_args"): words_in,
}
# By their tags, the option that sub-elements are, and how they are read; `*` are actions.
_PARTS: dict[str, tuple[str, Callable[[list[_Element]], Any]]] = {
    "*": ("actions", lambda found: [*map(_action, found)]),
    "arg": ("launch_arguments", _pairs),
    "choice": ("choices", lambda found: [unescaped(e.need("value")) for e in found] or None),
    "env": ("additional_env", lambda found: dict(_pairs(found))),
    "keep": ("launch_configurations", lambda found: dict(_pairs(found))),
    "param": ("parameters", lambda found: [*map(_parameter, found)]),
    "remap": ("remappings", lambda found: _pairs(found, "from", "to")),
}
_NODE = (
    "executable=exec package=pkg? name? namespace? output? respawn? respawn_delay? arguments=args? "
    "ros_arguments=ros_args? cwd? prefix=launch-prefix? on_exit? exec_name? shell? "
    "respawn_max_retries? emulate_tty? sigterm_timeout? sigkill_timeout?"
)
_NOT_HERE = (
    "executable load_composable_node node_container reset reset_env ros_timer set_ros_log_dir "
    "set_use_sim_time shutdown"
)
# By tag, the action, the attributes that are its options, and the tags of sub-elements.
_ACTIONS: dict[str, tuple[Any, ...]] = {
    "append_env": (actions.AppendEnvironmentVariable, "name value separator? prepend?"),
    "arg": (actions.DeclareLaunchArgument, "name default_value=default? description?", "choice"),
    "group": (actions.GroupAction, "scoped? forwarding?", "keep", "*"),
    "include": (actions.IncludeLaunchDescription, "launch_description_source=file", "arg"),
    "let": (actions.SetLaunchConfiguration, "name value"),
    "log": (actions.LogInfo, "msg=message"),
    "node": (ros_actions.Node, _NODE, "remap", "param", "env"),
    "push-ros-namespace": (ros_actions.PushROSNamespace, "namespace"),
    "push_ros_namespace": (ros_actions.PushROSNamespace, "namespace"),
    "set_env": (actions.SetEnvironmentVariable, "name value"),
    "set_parameter": (ros_actions.SetParameter, "name value"),
    "set_parameters_from_file": (ros_actions.SetParametersFromFile, "filename"),
    "set_remap": (ros_actions.SetRemap, "src=from dst=to"),
    "timer": (actions.TimerAction, "period cancel_on_shutdown?", "*"),
    "unset_env": (actions.UnsetEnvironmentVariable, "name"),
    **{tag: (absent_class(tag), "") for tag in _NOT_HERE.split()},
}
LOADERS = {
    **dict.fromkeys((".xml", ".launch"), _load(_read_xml)),
    **dict.fromkeys((".yaml", ".yml"), _load(_read_yaml)),
}
