"""A maker of message classes from interface descriptions, with the surface of rosidl's own.

Examples are `BatteryStatus(percentage=87.5)`, checked assignment, `==`, `repr` and
`get_fields_and_field_types()`.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from operator import attrgetter
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

from . import fields as rules
from .idl import Field, FieldType, Section, parse_text

Resolve = Callable[[Section, Field], Any]


class _MessageType(type):
    """The metaclass of messages; assigning to a constant of a message raises AttributeError."""

    def __setattr__(cls, name: str, value: Any) -> None:
        if name.isupper() and hasattr(cls, name):
            raise AttributeError(f"{name} of {cls.__name__} is a constant")
        super().__setattr__(name, value)


class Message(metaclass=_MessageType):
    """The base of every generated message, request, goal and so on.

    Assigning a wrong value to a field raises AssertionError (ValueError for bytes as numbers of a
    fixed size); an unknown field raises AttributeError. Messages have no hash.
    """

    __slots__ = ()
    __type_name__: ClassVar[str]
    __field_types__: ClassVar[dict[str, str]]
    # Name, slot, check and default of each field.
    __inits__: ClassVar[tuple[tuple[str, str, rules.Check, Callable[[], Any]], ...]]
    __copiers__: ClassVar[tuple[tuple[str, Callable[[Any], Any] | None], ...]]
    __layout__: ClassVar[tuple[tuple[str, FieldType, Any], ...]]  # Slot, type, nested class.

    def __init__(self, **values: Any) -> None:
        values.pop("check_fields", None)
        for name, slot, check, default in self.__inits__:
            given = values.pop(name) if name in values else default()
            if hasattr(given, "__next__"):  # As `map` gives: rosidl's constructors take it.
                given = list(given)
            setattr(self, slot, check(given))
        if values:
            raise AssertionError(f"Invalid arguments passed to constructor: {', '.join(values)}")

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        """Return a new dict of field names and types in rosidl's notation, in the file's order."""
        return dict(cls.__field_types__)

    def __received__(self) -> Any:
        """Return a copy that shares nothing, as if sent and received: float32 is rounded."""
        new = object.__new__(type(self))
        for slot, copy in self.__copiers__:
            value = getattr(self, slot)
            setattr(new, slot, value if copy is None else copy(value))
        return new

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return False
        return all(getattr(self, name) == getattr(other, name) for name in self.__field_types__)

    __hash__ = None  # type: ignore[assignment]  # mutable, as rosidl's

    def __repr__(self) -> str:
        package, kind, name = self.__type_name__.split("/")
        values = ((field, getattr(self, field)) for field in self.__field_types__)
        inside = ", ".join(
            f"{field}={list(value) if type(value) is array else value!r}" for field, value in values
        )
        return f"{package}.{kind}.{name}({inside})"


def make_message(type_name: str, section: Section, resolve: Resolve) -> type[Message]:
    """Return a new message class."""
    package, kind, name = type_name.split("/")
    body: dict[str, Any] = {
        "__slots__": tuple(f"_{field.name}" for field in section.fields),
        "__module__": f"{package}.{kind}",
        "__type_name__": type_name,
        "__field_types__": {field.name: str(field.type) for field in section.fields},
        **{name: rules.from_file(kind, value) for name, kind, value in section.constants},
    }
    inits: list[tuple[str, str, rules.Check, Callable[[], Any]]] = []
    copiers: list[tuple[str, Callable[[Any], Any] | None]] = []
    layout: list[tuple[str, FieldType, Any]] = []
    for field in section.fields:
        nested = resolve(section, field) if "/" in field.type.base else None
        check = rules.check_of(field.name, field.type, nested)
        slot = f"_{field.name}"
        body[field.name] = property(attrgetter(slot), _setter(slot, check))
        inits.append((field.name, slot, check, _default(field, nested)))
        layout.append((slot, field.type, nested))
        copiers.append((slot, rules.copier(field.type, check, nested)))
    body["__inits__"] = tuple(inits)
    body["__copiers__"] = tuple(copiers)
    body["__layout__"] = tuple(layout)
    return type(name, (Message,), body)


def make_service(type_name: str, sections: list[Section], resolve: Resolve) -> type:
    """Return a new service class with `Request` and `Response`.

    Creating an instance of the class raises NotImplementedError.
    """
    parts = {
        part: make_message(f"{type_name}_{part}", section, resolve)
        for part, section in zip(("Request", "Response"), sections, strict=True)
    }
    return _holder(type_name, parts)


def make_action(
    type_name: str, sections: list[Section], resolve: Resolve, load: Callable[[str], Any]
) -> type:
    """Return a new action class with `Goal`, `Result` and `Feedback`.

    `Impl` holds the services and messages that an action consists of on the graph. Creating an
    instance of the class raises NotImplementedError.
    """
    package, path, known = type_name.split("/")[0], Path(type_name), {}
    for part, section in zip(("Goal", "Result", "Feedback"), sections, strict=True):
        known[f"{package}/{path.name}_{part}"] = make_message(
            f"{type_name}_{part}", section, resolve
        )

    def within(section: Section, field: Field) -> Any:
        return known.get(field.type.base) or resolve(section, field)

    def made(name: str, *texts: str) -> Any:
        text = "\n---\n".join(texts).format(path.name)
        found = parse_text(text, path, package, len(texts))
        make: Any = make_service if len(texts) > 1 else make_message
        return make(f"{type_name}_{name}", found if len(texts) > 1 else found[0], within)

    goal_id = "unique_identifier_msgs/UUID goal_id\n"
    impl = SimpleNamespace(
        SendGoalService=made(
            "SendGoal",
            goal_id + "{}_Goal goal",
            "bool accepted\nbuiltin_interfaces/Time stamp",
        ),
        GetResultService=made("GetResult", goal_id, "int8 status\n{}_Result result"),
        FeedbackMessage=made("FeedbackMessage", goal_id + "{}_Feedback feedback"),
        CancelGoalService=load("action_msgs/srv/CancelGoal"),
        GoalStatusMessage=load("action_msgs/msg/GoalStatusArray"),
    )
    parts = {name.rpartition("_")[2]: message for name, message in known.items()}
    return _holder(type_name, {**parts, "Impl": impl})


def _holder(type_name: str, parts: dict[str, Any]) -> type:
    package, kind, name = type_name.split("/")
    told = f"{'Action' if kind == 'action' else 'Service'} classes can not be instantiated"

    def refuse(_: Any) -> None:
        raise NotImplementedError(told)

    where = {"__module__": f"{package}.{kind}", "__type_name__": type_name, "__init__": refuse}
    return type(name, (), {**where, **parts})


def _setter(slot: str, check: Callable[[Any], Any]) -> Callable[[Any, Any], None]:
    return lambda self, value: setattr(self, slot, check(value))


def _default(field: Field, nested: Any) -> Callable[[], Any]:
    if field.default is not None:
        return lambda: rules.from_file(field.type, field.default)
    return lambda: rules.default_of(field.type, nested)
