"""The base of all stand-ins for launch: places, errors, the context, entities, and their walk."""

from __future__ import annotations

import heapq
import os
import reprlib
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import KW_ONLY, dataclass, fields
from pathlib import Path
from types import FrameType, SimpleNamespace
from typing import Any, NamedTuple

_STAND_INS = str(Path(__file__).parent)
_GENERATED = "<string>"  # The file of the constructors that dataclasses have.


class Place(NamedTuple):
    """A line of a file."""

    file: str
    line: int


_elements: list[Place] = []  # Of an XML or YAML file, each within the one before it.


@contextmanager
def at(place: Place) -> Iterator[None]:
    """Have what is made inside this context made in the line of an element."""
    _elements.append(place)
    try:
        yield
    finally:
        _elements.pop()


def calling_place() -> Place:
    """Return the line of the element that is read, or else of the nearest caller's launch file.

    `Place("", 0)` stands for none.
    """
    if _elements:
        return _elements[-1]
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and frame.f_code.co_filename.startswith((_STAND_INS, _GENERATED)):
        frame = frame.f_back
    return Place("", 0) if frame is None else Place(frame.f_code.co_filename, frame.f_lineno)


class SubstitutionFailure(RuntimeError):
    """The error for a mistake in a launch file: nothing of the file is run."""

    def __init__(self, msg: object, place: Place | None = None) -> None:
        super().__init__(msg)
        self.place = place


class SkipActionError(Exception):
    """The error for what is not supported or not here: the action that needs it is left out."""

    def __init__(self, text: str, place: Place | None = None) -> None:
        super().__init__(text)
        self.place = place  # Of the value that is missing; None for the action itself.


class LaunchContext:
    """The state that actions read and change: launch configurations, environment, results."""

    def __init__(self, *, argv: Iterable[str] | None = None, noninteractive: bool = True) -> None:
        self.argv = list(argv or ())
        # As ThisLaunchFile reads them; empty before the file is performed.
        self.locals = SimpleNamespace()
        # Those of the innermost scope, which actions change in place.
        self.launch_configurations: dict[str, Any] = {}
        self.environment = dict(os.environ)
        self.programs: list[dict[str, Any]] = []  # As LaunchedProgram has them.
        self.notes: list[dict[str, Any]] = []  # As LaunchNote has them, with a Place.
        # The actions of timers, a heap: by their time, then their number; and the locals of each.
        self.delayed: list[tuple[float, int, Iterable[Any], dict[str, Any]]] = []
        self.time = 0.0  # Seconds after the start that the evaluation has reached.
        # An argument that is given and neither declared nor read gets a note.
        self.read: set[str] = set()
        self.failed_at: Place | None = None  # The line of the action that raised an error.
        self._outer: dict[str, list[dict[str, Any]]] = {}  # Of the scopes around.

    def perform_substitution(self, substitution: Any) -> str:
        text: str = substitution.perform(self)
        return text

    def begin_scope(self, kind: str) -> None:
        """Begin a scope of `launch_configurations` or `environment`, with a copy of those here."""
        # A shallow copy, as launch makes it: lists in it are shared with the scope around.
        self._outer.setdefault(kind, []).append(dict(getattr(self, kind)))

    def end_scope(self, kind: str) -> None:
        setattr(self, kind, self._outer[kind].pop())

    def changed_environment(self) -> dict[str, str | None]:
        """Return the variables of the innermost scope that differ; None for one that is unset."""
        now = self.environment
        changed: dict[str, str | None] = {
            name: value for name, value in now.items() if os.environ.get(name) != value
        }
        return changed | dict.fromkeys(os.environ.keys() - now.keys())

    def note(self, place: Place, text: str, level: str = "WARN") -> None:
        self.notes.append({"place": place, "level": level, "text": text})


SomeSubstitutionsType = Any
Text = Any  # A text, a path, a substitution, or several of these that are joined.
Texts = Any  # Several of these.
Flag = Any  # A bool, or texts with a substitution that stand for one.
Number = Any  # A float, or texts with a substitution that stand for one.


@dataclass(eq=False)
class Made:
    """The base of what a launch file makes: its line is known, and what it is given is checked.

    A field that is annotated as Text becomes a list of substitutions, one as Texts a list of such
    lists; one as Flag or Number becomes that, or a list of substitutions. None stays None.
    """

    def __post_init__(self) -> None:
        self.place = calling_place()
        for field in fields(self):
            value, check = getattr(self, field.name), _CHECKS.get(str(field.type).split(" ")[0])
            if check is not None and value is not None:
                setattr(self, field.name, check(value))


@dataclass(eq=False)
class Substitution(Made):
    """The base of all substitutions: each stands for a text."""

    def perform(self, context: LaunchContext) -> str:
        """Return the text that the substitution stands for now; SubstitutionFailure without one."""
        raise NotImplementedError

    def describe(self) -> str:
        """Return the substitution as `--show-args` shows a default."""
        texts = [describe(getattr(self, f.name)) for f in fields(self) if f.type == "Text"]
        return f"{type(self).__name__}({', '.join(texts)})"


@dataclass(eq=False)
class TextSubstitution(Substitution):
    """A text that stands for itself."""

    _: KW_ONLY
    text: str

    def perform(self, context: LaunchContext) -> str:
        return self.text

    def describe(self) -> str:
        return self.text


def describe(parts: Iterable[Substitution]) -> str:
    """Return the parts of a text as `--show-args` shows a default."""
    return "".join(part.describe() for part in parts)


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
    if isinstance(given, Substitution):
        return True
    if isinstance(given, (str, Mapping)) or not isinstance(given, Iterable):
        return False
    parts = list(given)
    of_text = all(isinstance(part, (Substitution, str)) for part in parts)
    return of_text and any(isinstance(part, Substitution) for part in parts)


def _flag(given: Any) -> Any:
    if isinstance(given, bool):
        return given
    if not is_substitution(given):
        raise TypeError(f"True, False or a substitution is wanted, not {given!r}")
    return normalize_to_list_of_substitutions(given)


def _number(given: Any) -> Any:
    if is_substitution(given):
        return normalize_to_list_of_substitutions(given)
    if isinstance(given, bool):
        raise TypeError(f"a number or a substitution is wanted, not {given!r}")
    return float(given)


_CHECKS: dict[str, Callable[[Any], Any]] = {
    "Text": normalize_to_list_of_substitutions,
    "Texts": lambda given: [normalize_to_list_of_substitutions(part) for part in given],
    "Flag": _flag,
    "Number": _number,
}


def perform_substitutions(context: LaunchContext, parts: Iterable[Substitution]) -> str:
    """Return the texts of several substitutions, joined."""
    return "".join([context.perform_substitution(part) for part in parts])


def perform(context: LaunchContext, given: Text) -> str:
    """Return the text of what a launch file gives: a text, a substitution, or a list of them."""
    return perform_substitutions(context, normalize_to_list_of_substitutions(given))


@dataclass(eq=False)
class Condition(Made):
    """The base of the rules that decide whether an action is performed."""

    def evaluate(self, context: LaunchContext) -> bool:
        raise NotImplementedError


@dataclass(eq=False)
class LaunchDescriptionEntity(Made):
    """The base of everything that a launch description contains."""

    def visit(self, context: LaunchContext) -> Iterable[Any] | None:
        """Perform the entity, and return the entities to perform next; None for none."""
        raise NotImplementedError

    def is_conditional(self) -> bool:
        """Return True if only the evaluation tells whether the entity is performed."""
        return False

    def sub_entities(self) -> Iterable[Any]:
        """Return the contained entities that are known before the evaluation; by default none."""
        return ()


@dataclass(eq=False)
class Action(LaunchDescriptionEntity):
    """The base of all actions, which are performed only if their condition holds."""

    _: KW_ONLY
    condition: Condition | None = None

    def visit(self, context: LaunchContext) -> Iterable[Any] | None:
        if self.condition is None or self.condition.evaluate(context):
            return self.execute(context)
        return None

    def execute(self, context: LaunchContext) -> Iterable[Any] | None:
        """Perform the action, and return the entities to perform next; None for none."""
        raise NotImplementedError

    def is_conditional(self) -> bool:
        return self.condition is not None


class LaunchDescription(LaunchDescriptionEntity):
    """The entities that `generate_launch_description()` returns."""

    def __init__(
        self, initial_entities: Iterable[Any] | None = None, *, deprecated_reason: str | None = None
    ) -> None:
        super().__init__()
        self.entities = list(initial_entities or ())
        self._deprecated_reason = deprecated_reason

    def add_action(self, action: Any) -> None:
        self.entities.append(action)

    add_entity = add_action

    def visit(self, context: LaunchContext) -> Iterable[Any] | None:
        if self._deprecated_reason is not None:
            context.note(self.place, f"deprecated: {self._deprecated_reason}")
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
        if isinstance(entity, LaunchDescriptionEntity):
            conditional = is_conditional or entity.is_conditional()
            yield entity, conditional
            yield from known_entities(entity.sub_entities(), conditional)


def visit(entity: Any, context: LaunchContext, within: Place) -> None:
    """Perform an entity, then those that it returns; leave out what is not supported."""
    if not isinstance(entity, LaunchDescriptionEntity):
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
        context.failed_at = entity.place
        raise
    for part in found or ():
        visit(part, context, entity.place)


def visit_delayed(context: LaunchContext) -> None:
    """Perform the actions of timers in the order of their times, without waiting."""
    while context.delayed:
        context.time, _, actions, local_values = heapq.heappop(context.delayed)
        vars(context.locals).update(local_values)
        for action in actions:
            visit(action, context, Place("", 0))
