"""The base of all stand-ins for launch: places, errors, texts, values, the context, the walk."""

from __future__ import annotations

import heapq
import os
import reprlib
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import KW_ONLY, dataclass, fields
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple, get_args, get_origin

import yaml

_STAND_INS = str(Path(__file__).parent)
_GENERATED = "<string>"  # The file of the constructors that dataclasses have.
_SCALARS = (bool, int, float, str)


class Place(NamedTuple):
    """A line of a file."""

    file: str
    line: int


_elements: list[Place] = []  # Of an XML or YAML file, each within the one before it.


@contextmanager
def at(place: Place) -> Iterator[None]:
    """Give all actions and substitutions that are made in this context the line of an element."""
    _elements.append(place)
    try:
        yield
    finally:
        _elements.pop()


def calling_place() -> Place:
    """Return the line of the element that is read, or else of the nearest caller's launch file."""
    if _elements:
        return _elements[-1]
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and frame.f_code.co_filename.startswith((_STAND_INS, _GENERATED)):
        frame = frame.f_back
    return Place("", 0) if frame is None else Place(frame.f_code.co_filename, frame.f_lineno)


class _PlacedError(RuntimeError):
    def __init__(self, msg: object, place: Place | None = None) -> None:
        super().__init__(msg)
        self.place = place  # None for that of the action.


class SubstitutionFailure(_PlacedError):
    """The error for a mistake in a launch file: nothing of the file is run."""


class SkipActionError(_PlacedError):
    """The error for what is not supported or not here: the action that needs it is left out."""


class LaunchContext:
    """The state that actions read and change: launch configurations, environment, results."""

    def __init__(self, *, argv: Iterable[str] | None = None, noninteractive: bool = True) -> None:
        self.argv = list(argv or ())
        # Of the innermost scope.
        self.launch_configurations: dict[str, Any] = {}
        self.environment = dict(os.environ)
        self.launch_file = ""  # The one that is performed, or was included last.
        self.programs: list[dict[str, Any]] = []  # As LaunchedProgram has them.
        self.notes: list[dict[str, Any]] = []  # As LaunchNote has them, with a Place.
        # A heap of the timers' actions: by their time, then their number; and the file of each.
        self.delayed: list[tuple[float, int, Iterable[Any], str]] = []
        self.time = 0.0  # Seconds after the start that the evaluation has reached.
        # An argument that is given and neither declared nor read gets a note.
        self.read: set[str] = set()
        self.failed_at: Place | None = None  # The line of the action that raised an error.

    def perform_substitution(self, substitution: Any) -> str:
        text: str = substitution.perform(self)
        return text

    @contextmanager
    def scope(self) -> Iterator[None]:
        """Restore the launch configurations and the environment when the context ends."""
        before = self.launch_configurations, self.environment
        # Shallow copies, as launch makes them: lists in them are shared with the scope around.
        self.launch_configurations, self.environment = map(dict, before)
        yield
        self.launch_configurations, self.environment = before

    def changed_environment(self) -> dict[str, str | None]:
        """Return the variables of the innermost scope that differ; None for one that is unset."""
        changed: dict[str, str | None] = dict(self.environment.items() - os.environ.items())
        return changed | dict.fromkeys(os.environ.keys() - self.environment.keys())

    def note(self, place: Place, text: str, level: str = "WARN") -> None:
        self.notes.append({"place": place, "level": level, "text": text})


SomeSubstitutionsType = Any
Text = Any  # A text, a path, a substitution, or several of these that are joined.
Texts = Any  # Several of these.


@dataclass(eq=False)
class Made:
    """The base of what a launch file makes, which knows its line.

    A field that is annotated as Text becomes a list of substitutions, one as Texts a list of such
    lists; None stays None.
    """

    def __post_init__(self) -> None:
        self.place = calling_place()
        for field in fields(self):
            value, kind = getattr(self, field.name), str(field.type).split(" ")[0]
            if value is not None and kind == "Text":
                setattr(self, field.name, normalize_to_list_of_substitutions(value))
            elif value is not None and kind == "Texts":
                setattr(self, field.name, [*map(normalize_to_list_of_substitutions, value)])


@dataclass(eq=False)
class Substitution(Made):
    """The base of all substitutions: each stands for a text."""

    def perform(self, context: LaunchContext) -> str:
        """Return the text that the substitution stands for now; SubstitutionFailure without one."""
        raise NotImplementedError

    def describe(self) -> str:
        """Return the substitution as `--show-args` shows a default."""
        values = [getattr(self, field.name) for field in fields(self)]
        return f"{type(self).__name__}({', '.join(described(v) for v in values if v)})"


@dataclass(eq=False)
class TextSubstitution(Substitution):
    """A text that stands for itself."""

    _: KW_ONLY
    text: str

    def perform(self, context: LaunchContext) -> str:
        return self.text

    def describe(self) -> str:
        return self.text


def described(given: Any) -> str:
    """Return the parts of a text as `--show-args` shows a default."""
    if isinstance(given, list):
        return "".join(map(described, given))
    return given.describe() if isinstance(given, Substitution) else str(given)


def normalize_to_list_of_substitutions(given: Text) -> list[Substitution]:
    """Return a text, a path, a substitution, or several of them, as a list of substitutions."""
    if isinstance(given, Iterable) and not isinstance(given, (str, os.PathLike)):
        return [_part(part) for part in given]
    return [_part(given)]


def _part(given: object) -> Substitution:
    if isinstance(given, Substitution):
        return given
    if isinstance(given, (str, os.PathLike)):
        return TextSubstitution(text=os.fspath(given))
    is_plain = isinstance(given, (bool, int, float))
    hint = f": write '{str(given).lower()}'" if is_plain else ""
    kind = type(given).__name__
    raise TypeError(f"a text or a substitution is wanted, not {kind} {given!r}{hint}")


def is_substitution(given: object) -> bool:
    """Return True for a substitution, or a list with one; a list of texts alone is none."""
    parts = given if isinstance(given, (list, tuple)) else [given]
    of_text = all(isinstance(part, (Substitution, str)) for part in parts)
    return of_text and any(isinstance(part, Substitution) for part in parts)


def perform_substitutions(context: LaunchContext, parts: Iterable[Substitution]) -> str:
    """Return the texts of several substitutions, joined."""
    return "".join([context.perform_substitution(part) for part in parts])


def perform(context: LaunchContext, given: Text) -> str:
    """Return the text of what a launch file gives: a text, a substitution, or a list of them."""
    return perform_substitutions(context, normalize_to_list_of_substitutions(given))


def performed(context: LaunchContext, given: Mapping[Any, Any] | None) -> dict[str, str]:
    """Return the texts of a mapping's names and values."""
    pairs = (given or {}).items()
    return {perform(context, name): perform(context, value) for name, value in pairs}


def value_of(context: LaunchContext, given: Any, kind: Any = None) -> Any:
    """Return a value, which has a type such as `int` or `list[int]`, or any that ROS knows.

    The text of a substitution is read as YAML 1.1. Raises ValueError.
    """
    value, part_kind = given, get_args(kind)[0] if get_origin(kind) is list else None
    if is_substitution(given):
        given = perform(context, given)
        value = _value_of_text(given, kind)
    elif isinstance(given, Iterable) and not isinstance(given, (str, Mapping)):
        value = [p if isinstance(p, _SCALARS) else value_of(context, p, part_kind) for p in given]
        if {type(part) for part in value} == {int, float}:
            value = [float(part) for part in value]
        given = value
    is_list = isinstance(value, list)
    parts = value if is_list else [value]
    wanted = kind if kind in _SCALARS else part_kind or (type(parts[0]) if parts else str)
    fits = kind is None or is_list == (kind not in _SCALARS)
    if not fits or wanted not in _SCALARS or not all(isinstance(part, wanted) for part in parts):
        raise _wrong_value(given, kind)
    return value


def _value_of_text(text: str, kind: Any) -> Any:
    try:
        if kind in (str, int, float):
            return kind(text)
        if kind is bool:  # launch takes these two besides YAML's words.
            text = {"1": "true", "0": "false"}.get(text, text)
        return yaml.safe_load(text) if text else text
    except (ValueError, yaml.YAMLError):
        raise _wrong_value(text, kind) from None


def _wrong_value(given: Any, kind: Any) -> ValueError:
    if kind is None:
        return ValueError(f"{given!r} is no number, boolean, text or list of values of one type")
    return ValueError(f"{given!r} is not of type {kind.__name__ if kind in _SCALARS else kind}")


def flag(context: LaunchContext, given: Any) -> bool:
    """Return the bool that something stands for."""
    return bool(value_of(context, given, bool))


def number(context: LaunchContext, given: Any) -> float:
    """Return the float that something stands for."""
    return float(value_of(context, float(given) if isinstance(given, int) else given, float))


@dataclass(eq=False)
class Condition(Made):
    """The base of the rules that decide whether an action is performed."""

    def evaluate(self, context: LaunchContext) -> bool:
        raise NotImplementedError


@dataclass(eq=False)
class Action(Made):
    """The base of everything that is performed, if its condition holds."""

    _: KW_ONLY
    condition: Condition | None = None

    def visit(self, context: LaunchContext) -> Iterable[Any] | None:
        """Perform the entity if its condition holds; return the entities to perform next."""
        if self.condition is None or self.condition.evaluate(context):
            return self.execute(context)
        return None

    def execute(self, context: LaunchContext) -> Iterable[Any] | None:
        raise NotImplementedError

    def sub_entities(self) -> Iterable[Any]:
        """Return the contained entities that are known before the evaluation; by default none."""
        return ()


LaunchDescriptionEntity = Action


class LaunchDescription(Action):
    """The entities that `generate_launch_description()` returns."""

    def __init__(self, initial_entities: Iterable[Any] | None = None, **_: Any) -> None:
        super().__init__()
        self.entities = list(initial_entities or ())

    def add_action(self, action: Any) -> None:
        self.entities.append(action)

    add_entity = add_action

    def execute(self, context: LaunchContext) -> Iterable[Any]:
        return self.entities

    def sub_entities(self) -> Iterable[Any]:
        return self.entities


def known_entities(
    entities: Iterable[Any], is_conditional: bool = False
) -> Iterator[tuple[Any, bool]]:
    """Yield all entities that are known before the evaluation, and True for a conditional one.

    Included files whose paths are known are loaded, which runs the code in them; one that fails
    counts as empty.
    """
    for entity in entities:
        if isinstance(entity, Action):
            conditional = is_conditional or entity.condition is not None
            yield entity, conditional
            yield from known_entities(entity.sub_entities(), conditional)


def visit(entity: Any, context: LaunchContext, within: Place) -> None:
    """Perform an entity, then those that it returns; leave out what is not supported."""
    if not isinstance(entity, Action):
        text = f"an action is wanted, not a {type(entity).__name__}: {reprlib.repr(entity)}"
        raise SubstitutionFailure(text, within)
    try:
        found = entity.visit(context)
    except SkipActionError as error:
        place = error.place or entity.place
        needed_by = f" (line {entity.place.line})" if place != entity.place else ""
        context.note(place, f"{error}{needed_by}")
        return
    except Exception:
        context.failed_at = context.failed_at or entity.place
        raise
    for part in found or ():
        visit(part, context, entity.place)


def visit_delayed(context: LaunchContext) -> None:
    """Perform the actions of timers in the order of their times, without waiting."""
    while context.delayed:
        context.time, _, actions, context.launch_file = heapq.heappop(context.delayed)
        for action in actions:
            visit(action, context, Place("", 0))
