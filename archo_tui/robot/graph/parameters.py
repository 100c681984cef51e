"""A mirror of the parameters of all nodes on the graph. ROS thread only.

Every value in it is one that its node reported, by `get_parameters` or on `/parameter_events`,
never one that was only requested.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Mapping
from copy import deepcopy
from functools import partial
from operator import is_
from typing import Any

from rcl_interfaces import srv
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterEvent, ParameterType, ParameterValue
from rclpy.parameter import Parameter as RosParameter

from archo_tui.base.safe_text import harmless
from archo_tui.robot.graph.parameter_values import (
    TYPES,
    as_python,
    is_secret,
    masked,
    masked_text,
    value_field,
)
from archo_tui.robot.messages.values import checked, same, text_of
from archo_tui.robot.node import DEADLINE
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.runtime import Runtime
from archo_tui.robot.state.graph import MASK, NO_PARAMETER_SERVICES, NOT_REPORTED, Parameter
from archo_tui.robot.stop.gate import Gate

_RETRY, _LONGEST_RETRY = 2.0, 60.0  # Seconds until a node is asked again that did not answer.
_DEPTH = 1000  # Messages on /parameter_events that are kept while the thread is busy.
PERIOD = 30.0  # Seconds after which the parameters of a node are read again, at least.
MOST_AGAIN = 5  # Nodes that are read again at a poll, of which there is one a second.


class _NodeParameters:
    """The parameters of one node, as far as they are known."""

    def __init__(self) -> None:
        self.parameters: dict[str, Parameter] | None = None  # None until it has answered.
        self.count = 0  # The nodes of this name at the last poll.
        self.is_serving = self.is_loading = False
        self.due = -math.inf  # When it is asked again, in monotonic seconds,
        self.wait = _RETRY  # and how much later, in seconds, if it does not answer then.

    def get(self, name: str) -> Parameter | None:
        return None if self.parameters is None else self.parameters.get(name)

    def forget(self) -> None:
        """Have the next poll load all of them."""
        self.parameters, self.due = None, -math.inf


_UNKNOWN = _NodeParameters()  # Of a node that no poll has found.


class Parameters:
    """A mirror of the parameters of all nodes: loads them, follows their changes, and sets them."""

    def __init__(
        self,
        runtime: Runtime,
        on_new_value: Callable[[str, Any, Any], None],
        on_event: Callable[[str, str, Any, Any], None],
    ) -> None:
        self._node, self._clock = runtime.node, runtime.clock
        self._submit, self._on_change = runtime.thread.submit, runtime.snapshots.send_soon
        self._on_new_value, self._tell_event = on_new_value, on_event
        self._nodes: dict[str, _NodeParameters] = {}
        self._all: tuple[Parameter, ...] = ()  # What `all` returned last.
        self._node.listen_quietly(ParameterEvent, "/parameter_events", self._on_event, _DEPTH)

    def all(self) -> tuple[Parameter, ...]:
        """Return all parameters, sorted by node; those of a node in the order of its list.

        The tuple is the same object until something changes.
        """
        nodes = (self._nodes[node].parameters for node in sorted(self._nodes))
        found = [parameter for known in nodes if known for parameter in known.values()]
        if len(found) != len(self._all) or not all(map(is_, found, self._all)):
            self._all = tuple(found)
        return self._all

    @property
    def unreported(self) -> dict[str, str]:
        """The nodes whose parameters are not in the mirror, by full name, each with the reason."""
        return {
            node: NOT_REPORTED if known.is_serving else NO_PARAMETER_SERVICES
            for node, known in self._nodes.items()
            if known.parameters is None
        }

    def poll(self, nodes: Mapping[str, int], offered: Container[str]) -> None:
        """Begin to load the parameters of new nodes, and to read a part of the others again."""
        for gone in self._nodes.keys() - nodes.keys():
            del self._nodes[gone]
            self._node.destroy_clients(gone)
            self._on_change()
        now, before = self._clock.monotonic(), self.unreported
        for name, count in nodes.items():
            known = self._nodes.setdefault(name, _NodeParameters())
            known.is_serving = f"{name}/list_parameters" in offered
            is_due = now >= known.due if known.parameters is None else count > known.count
            known.count = count
            if is_due and known.is_serving and not known.is_loading:
                known.is_loading = True
                self._submit(partial(self._load, name, known))
        if self.unreported != before:
            self._on_change()
        # Those that have waited longest are read again, a few at each poll.
        loaded = [node for node, known in self._nodes.items() if known.parameters is not None]
        waiting = sorted(loaded, key=lambda node: self._nodes[node].due)
        for node in waiting[: min(MOST_AGAIN, 1 + len(waiting) // int(PERIOD))]:
            if now >= self._nodes[node].due and not self._nodes[node].is_loading:
                self._nodes[node].due = now + PERIOD
                self._submit(partial(self._refresh, node, self._nodes[node]))

    async def _refresh(self, node: str, known: _NodeParameters) -> None:
        """Read the parameters of a node again; if it has others now, forget it, to load it anew."""
        # A parameter without a value cannot be read; its node publishes when it gets one.
        parameters = (known.parameters or {}).values()
        names = [parameter.name for parameter in parameters if parameter.value is not None]
        got = await self._values(node, names) if names else {}
        if got is not None and len(got) != len(names):
            known.forget()
        for name, value in (got or {}).items():
            self._take(node, name, value)

    async def _values(self, node: str, names: list[str]) -> dict[str, Any] | None:
        """Ask a node for values; return those that are set, by name, or None if none come."""
        got = await self._node.call(
            srv.GetParameters, f"{node}/get_parameters", srv.GetParameters.Request(names=names)
        )
        if got is None:
            return None
        if len(got.values) == len(names):
            return {n: as_python(v) for n, v in zip(names, got.values, strict=True)}
        found: dict[str, Any] = {}
        for name in names if len(names) > 1 else ():  # One without a value hides all.
            alone = await self._values(node, [name])
            if alone is None:
                return None
            found |= alone
        return found

    async def _load(self, node: str, known: _NodeParameters) -> None:
        """Load all parameters of a node; if it does not answer, set when it is asked again."""
        try:
            listed = await self._node.call(
                srv.ListParameters,
                f"{node}/list_parameters",
                srv.ListParameters.Request(),
                once=True,
            )
            names = list(listed.result.names) if listed is not None else []
            described = await self._node.call(
                srv.DescribeParameters,
                f"{node}/describe_parameters",
                srv.DescribeParameters.Request(names=names),
                once=True,
            )
            got = await self._values(node, names)
            if listed is None or described is None or got is None:
                known.due = self._clock.monotonic() + known.wait
                known.wait = min(2 * known.wait, _LONGEST_RETRY)
                return
            known.due, known.wait = self._clock.monotonic() + PERIOD, _RETRY
            known.parameters = {
                name: _parameter(node, name, descriptor, got.get(name))
                for name, descriptor in zip(names, described.descriptors, strict=False)
            }
            self._on_change()
        finally:
            known.is_loading = False

    async def set(self, node: str, values: Mapping[str, Any], gate: Gate) -> Outcome:
        """Set all of these parameters of a node or none, and read them back; Void behind a STOP."""
        before = self._event_texts(node, values)
        try:
            parameters = [self._message(node, name, value) for name, value in values.items()]
        except ValueError as error:
            return Outcome(Code.MISUSE, str(error))
        request = srv.SetParametersAtomically.Request(parameters=parameters)
        answer = await self._node.call(
            srv.SetParametersAtomically,
            f"{node}/set_parameters_atomically",
            request,
            gate=gate,
        )
        if answer is None:
            return Outcome(Code.TIMEOUT, f"no answer in {DEADLINE:g} s from {node}")
        if not answer.result.successful:
            reason = masked_text(answer.result.reason, values)
            return Outcome(Code.REFUSED, reason or "refused, no reason given")
        got = await self._values(node, list(values))
        if got is None:
            were = ", ".join(f"{name} was {text}" for name, text in before.items())
            unread = f"accepted, but {node} has not reported the new value"
            return Outcome(Code.DONE, f"{unread}; {were}")
        for name, value in got.items():
            self._take(node, name, value)
        now = self._event_texts(node, values)
        text = ", ".join(f"{name} is {now[name]}, was {before[name]}" for name in before)
        return Outcome(Code.DONE, text)

    def _event_texts(self, node: str, names: Iterable[str]) -> dict[str, str]:
        """Return the known values by name as texts for an event, with MASK in place of secrets."""
        known = masked({name: self._value(node, name) for name in names})
        return {name: text_of(value) for name, value in known.items()}

    def _message(self, node: str, name: str, value: Any) -> Any:
        """Return the message that sets a parameter; its type is that of the value."""
        known = self._nodes.get(node, _UNKNOWN).get(name)
        if value == [] and known is not None:  # An empty list alone does not tell its type.
            number = next((number for number, kind in TYPES.items() if kind == known.type), 0)
        else:
            number = RosParameter(name, value=value).type_.value
        made = ParameterMessage(name=name, value=ParameterValue(type=number))
        if number in TYPES:
            field = value_field(TYPES[number])
            kinds = ParameterValue.get_fields_and_field_types()
            setattr(made.value, field, checked(kinds[field], value, name))
        return made

    def _value(self, node: str, name: str) -> Any:
        known = self._nodes.get(node, _UNKNOWN).get(name)
        return None if known is None else known.value

    def _on_event(self, event: ParameterEvent) -> None:
        for message in event.changed_parameters:
            old, new = self._value(event.node, message.name), as_python(message.value)
            if old is not None and not same(old, new):
                self._tell_event(event.node, message.name, old, new)
        for message in (*event.new_parameters, *event.changed_parameters):
            self._take(event.node, message.name, as_python(message.value))
        for message in event.deleted_parameters:
            known = self._nodes.get(event.node, _UNKNOWN).parameters
            if known is not None and known.pop(message.name, None) is not None:
                self._on_change()

    def _take(self, node: str, name: str, value: Any) -> None:
        known = self._nodes.get(node, _UNKNOWN)
        parameter = known.get(name)
        if known.parameters is None:
            return
        if parameter is None:
            if not known.is_loading:
                known.forget()  # It was declared later.
        elif not same(parameter.value, value):
            known.parameters[name] = parameter._replace(value=value)
            self._on_change()
            self._on_new_value(node, parameter.value, value)


def _parameter(node: str, name: str, descriptor: Any, value: Any) -> Parameter:
    low = high = None
    for allowed in (*descriptor.floating_point_range, *descriptor.integer_range):
        low, high = sorted((allowed.from_value, allowed.to_value))
    return Parameter(
        node=node,
        name=name,
        type=TYPES.get(descriptor.type or ParameterType.PARAMETER_NOT_SET, "not set"),
        value=value,
        initial=value,
        description=harmless(descriptor.description),
        low=low,
        high=high,
        read_only=descriptor.read_only,
        is_secret=is_secret(name),
    )


def without_secrets(message: ParameterEvent) -> ParameterEvent:
    """Return a message with MASK in place of secret values; the same object if it has none."""

    def secrets(event: ParameterEvent) -> list[ParameterMessage]:
        parts = (event.new_parameters, event.changed_parameters, event.deleted_parameters)
        return [parameter for part in parts for parameter in part if is_secret(parameter.name)]

    if not secrets(message):
        return message
    hidden = deepcopy(message)
    for parameter in secrets(hidden):
        parameter.value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=MASK)
    return hidden
