"""The base of all stand-ins for launch: places, errors, the context, entities, and their walk."""

from __future__ import annotations

import heapq
import os
import reprlib
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType, SimpleNamespace
from typing import Any, NamedTuple

_STAND_INS = str(Path(__file__).parent)


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
    while frame is not None and frame.f_code.co_filename.startswith(_STAND_INS):
        frame = frame.f_back
    return Place("", 0) if frame is None else Place(frame.f_code.co_filename, frame.f_lineno)


class SubstitutionFailure(RuntimeError):
    """The error for a mistake in a launch file: nothing of the file is run."""

    def __init__(self, msg: object, place: Place | None = None) -> None:
        super().__init__(msg)
        self.place = place


class InvalidLaunchFileError(SubstitutionFailure):
    """The error for a launch file that does not exist, or that describes nothing."""


class SkipActionError(Exception):
    """The error for what is not supported or not here: the action that needs it is left out."""

    def __init__(self, text: str, place: Place, is_value: bool = False) -> None:
        super().__init__(text)
        self.place, self.is_value = place, is_value


class Delayed(NamedTuple):
    """The actions of a timer; objects sort by their time, then by their number."""

    time: float  # Seconds after the start.
    number: int
    actions: Iterable[Any]
    local_values: dict[str, Any]  # The `locals` of the context when the timer began.


class LaunchContext:
    """The state that actions read and change: launch configurations, environment, results."""

    def __init__(self, *, argv: Iterable[str] | None = None, noninteractive: bool = True) -> None:
        self.argv = list(argv or ())
        # As ThisLaunchFile reads them; empty before the file is performed.
        self.locals = SimpleNamespace()
        self.programs: list[dict[str, Any]] = []  # As LaunchedProgram has them.
        self.notes: list[dict[str, Any]] = []  # As LaunchNote has them.
        self.delayed: list[Delayed] = []  # A heap.
        self.time = 0.0  # Seconds after the start that the evaluation has reached.
        # An argument that is given and neither declared nor read gets a note.
        self.read: set[str] = set()
        self.failed_at: Place | None = None  # The line of the action that raised an error.
        self.including: list[str] = []  # The paths of the files around the current action.
        self._configurations: dict[str, Any] = {}
        self._environment = dict(os.environ)
        self._pushed_configurations: list[dict[str, Any]] = []
        self._pushed_environments: list[dict[str, str]] = []

    @property
    def launch_configurations(self) -> dict[str, Any]:
        """The launch configurations of the innermost scope, which callers may change in place."""
        return self._configurations

    @property
    def environment(self) -> dict[str, str]:
        """The environment variables of the innermost scope, which callers may change in place."""
        return self._environment

    def perform_substitution(self, substitution: Any) -> str:
        text: str = substitution.perform(self)
        return text

    def push_configurations(self) -> None:
        # A shallow copy, as launch makes it: lists in it are shared with the scope around.
        self._pushed_configurations.append(dict(self._configurations))

    def pop_configurations(self) -> None:
        self._configurations = self._pushed_configurations.pop()

    def push_environment(self) -> None:
        self._pushed_environments.append(dict(self._environment))

    def pop_environment(self) -> None:
        self._environment = self._pushed_environments.pop()

    def reset_environment(self) -> None:
        self._environment = dict(os.environ)

    def changed_environment(self) -> dict[str, str | None]:
        """Return the variables of the innermost scope that differ; None for one that is unset."""
        now = self._environment
        changed: dict[str, str | None] = {
            name: value for name, value in now.items() if os.environ.get(name) != value
        }
        return changed | dict.fromkeys(os.environ.keys() - now.keys())

    def note(self, place: Place, text: str, level: str = "WARN") -> None:
        self.notes.append({"file": place.file, "line": place.line, "level": level, "text": text})


SomeSubstitutionsType = Any  # A text, a substitution, or several of them that are joined.


class Substitution:
    """The base of all substitutions: each stands for a text."""

    def __init__(self) -> None:
        self.place = calling_place()

    def perform(self, context: LaunchContext) -> str:
        """Return the text that the substitution stands for now; SubstitutionFailure without one."""
        raise NotImplementedError

    def describe(self) -> str:
        """Return the substitution as `--show-args` shows a default."""
        return type(self).__name__


class TextSubstitution(Substitution):
    """A text that stands for itself."""

    def __init__(self, *, text: str) -> None:
        super().__init__()
        if not isinstance(text, str):
            raise TypeError(f"TextSubstitution takes a text, not {text!r}")
        self.text = text

    def perform(self, context: LaunchContext) -> str:
        return self.text

    def describe(self) -> str:
        return self.text


def normalize_to_list_of_substitutions(given: SomeSubstitutionsType) -> list[Substitution]:
    """Return a text, a path, a substitution, or several of them, as a list of substitutions."""
    if isinstance(given, (str, os.PathLike, Substitution)):
        return [_part(given)]
    if isinstance(given, Iterable):
        return [_part(part) for part in given]
    raise TypeError(_wanted(given))


def _part(given: object) -> Substitution:
    if isinstance(given, Substitution):
        return given
    if isinstance(given, (str, os.PathLike)):
        return TextSubstitution(text=os.fspath(given))
    raise TypeError(_wanted(given))


def _wanted(given: object) -> str:
    is_plain = isinstance(given, (bool, int, float))
    hint = f": write '{str(given).lower() if isinstance(given, bool) else given}'"
    kind = type(given).__name__
    return f"a text or a substitution is wanted, not {kind} {given!r}{hint if is_plain else ''}"


def perform_substitutions(context: LaunchContext, parts: Iterable[Substitution]) -> str:
    """Return the texts of several substitutions, joined."""
    return "".join([context.perform_substitution(part) for part in parts])


def perform(context: LaunchContext, given: SomeSubstitutionsType) -> str:
    """Return the text of what a launch file gives: a text, a substitution, or a list of them."""
    return perform_substitutions(context, normalize_to_list_of_substitutions(given))


def is_substitution(given: object) -> bool:
    """Return True for a substitution, or a list with one; a list of texts alone is none."""
    if isinstance(given, Substitution):
        return True
    if isinstance(given, str) or not isinstance(given, Iterable):
        return False
    parts = list(given)
    of_text = all(isinstance(part, (Substitution, str)) for part in parts)
    return of_text and any(isinstance(part, Substitution) for part in parts)


class Condition:
    """A rule, given as a function of the context, that decides whether an action is performed."""

    def __init__(self, *, predicate: Callable[[LaunchContext], bool]) -> None:
        self.place = calling_place()
        self._predicate = predicate

    def evaluate(self, context: LaunchContext) -> bool:
        return self._predicate(context)


class LaunchDescriptionEntity:
    """The base of everything that a launch description contains."""

    declares_argument = resets_arguments = is_conditional = False

    def __init__(self) -> None:
        self.place = calling_place()

    def visit(self, context: LaunchContext) -> Iterable[Any] | None:
        """Perform the entity, and return the entities to perform next; None for none."""
        raise NotImplementedError

    def sub_entities(self) -> Iterable[Any]:
        """Return the contained entities that are known before the evaluation; by default none."""
        return ()

    def given_names(self) -> set[str]:
        """Return the names of the arguments that this entity gives to its sub-entities."""
        return set()


class Action(LaunchDescriptionEntity):
    """The base of all actions, which are performed only if their condition holds."""

    def __init__(self, *, condition: Condition | None = None) -> None:
        super().__init__()
        self.condition = condition
        self.is_conditional = condition is not None

    def visit(self, context: LaunchContext) -> Iterable[Any] | None:
        if self.condition is None or self.condition.evaluate(context):
            return self.execute(context)
        return None

    def execute(self, context: LaunchContext) -> Iterable[Any] | None:
        """Perform the action, and return the entities to perform next; None for none."""
        raise NotImplementedError


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


class DeclaredArgument(NamedTuple):
    """An argument that a launch file, or one that it includes, declares."""

    argument: Any  # The DeclareLaunchArgument.
    is_conditional: bool  # A condition or a timer decides whether it is declared.
    given: frozenset[str]  # By the includes around it.

    @property
    def is_required(self) -> bool:
        """True if a value must be given: there is no default, and no condition decides."""
        return self.argument.default_value is None and not self.is_conditional


def declared_arguments(entities: Iterable[Any]) -> list[DeclaredArgument]:
    """Return the arguments that entities declare; of several of a name, the first.

    Included files whose paths are known are loaded, which runs the code in them; one that fails
    counts as empty.
    """
    found: dict[str, DeclaredArgument] = {}
    for declared in _walk(entities, False, frozenset()):
        found.setdefault(declared.argument.name, declared)
    return list(found.values())


def _walk(
    entities: Iterable[Any], is_conditional: bool, given: frozenset[str]
) -> Iterator[DeclaredArgument]:
    for entity in entities:
        if not isinstance(entity, LaunchDescriptionEntity):
            continue  # The evaluation will tell.
        if entity.resets_arguments:
            return  # What is declared after it cannot be given any more.
        conditional = is_conditional or entity.is_conditional
        if entity.declares_argument:
            yield DeclaredArgument(entity, conditional, given)
        yield from _walk(entity.sub_entities(), conditional, given | entity.given_names())


def visit(entity: Any, context: LaunchContext, within: Place) -> None:
    """Perform an entity, then those that it returns; leave out what is not supported."""
    if not isinstance(entity, LaunchDescriptionEntity):
        text = f"an action is wanted, not a {type(entity).__name__}: {reprlib.repr(entity)}"
        raise SubstitutionFailure(text, within)
    around = len(context.including)
    try:
        found = entity.visit(context)
    except SkipActionError as error:
        is_elsewhere = error.is_value and error.place != entity.place
        needed_by = f" (line {entity.place.line})" if is_elsewhere else ""
        context.note(error.place, f"{error}{needed_by}")
        return
    except Exception:
        context.failed_at = entity.place
        raise
    for part in found or ():
        visit(part, context, entity.place)
    del context.including[around:]  # What the entity has included is over.


def visit_delayed(context: LaunchContext) -> None:
    """Perform the actions of timers in the order of their times, without waiting."""
    while context.delayed:
        delayed = heapq.heappop(context.delayed)
        context.time = delayed.time
        vars(context.locals).update(delayed.local_values)
        for action in delayed.actions:
            visit(action, context, Place("", 0))
