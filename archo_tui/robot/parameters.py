"""A mirror of the parameters of all nodes on the graph. ROS thread only.

It holds what the nodes answered: values come from `get_parameters` and `/parameter_events`, never
from what was asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping
from operator import is_
from typing import Any

from rcl_interfaces import srv
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterEvent, ParameterType, ParameterValue
from rclpy.parameter import Parameter as RosParameter

from archo_tui.clock import Clock
from archo_tui.robot import services
from archo_tui.robot.fields import checked
from archo_tui.robot.listener import Listener
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.parameter_polling import ParameterPolling
from archo_tui.robot.parameter_values import TYPES, as_python, value_field
from archo_tui.robot.secret_names import MASK, SecretNames
from archo_tui.robot.services import Services
from archo_tui.robot.state import Parameter
from archo_tui.robot.stops import Gate
from archo_tui.robot.text import harmless
from archo_tui.robot.values import same, text_of

_RETRY, _LONGEST_RETRY = 2.0, 60.0  # s until a node that did not answer is asked again
_DEPTH = 1000  # parameter events kept while the thread is busy


class Parameters:
    """Loads the parameters of nodes as they appear, follows their changes, sets them."""

    def __init__(
        self,
        node: Listener,
        clock: Clock,
        pending: Services,
        changed: Callable[[], None],
        set_anew: Callable[[str, Any, Any], None],
        told: Callable[[str, str, Any, Any], None],
        secrets: SecretNames,
    ) -> None:
        """`set_anew(node, old, new)` is called when a value has changed.

        `told(node, name, old, new)` when its node says so, whoever did it.
        """
        self._told = told
        self._secrets = secrets
        self._node, self._clock = node, clock
        self._set_anew = set_anew
        self._known: dict[str, int] = {}  # nodes of the last look, and how many of each
        self._retry: dict[str, tuple[float, float]] = {}  # of nodes that did not answer: when, s
        self._services = pending
        self._changed = changed
        self._by_node: dict[str, dict[str, Parameter]] = {}
        self._all: tuple[Parameter, ...] = ()  # as they were last asked for
        self._loading: set[str] = set()
        self._polling = ParameterPolling()
        node.listen_quietly(ParameterEvent, "/parameter_events", self._on_event, _DEPTH)

    def all(self) -> tuple[Parameter, ...]:
        """By node, then in the order in which the node declared them.

        The same object until something changes.
        """
        found = [p for node in sorted(self._by_node) for p in self._by_node[node].values()]
        if len(found) != len(self._all) or not all(map(is_, found, self._all)):
            self._all = tuple(found)
        return self._all

    def follow(self, nodes: Mapping[str, int], offered: Container[str]) -> None:
        """Load nodes that are new on the graph and offer parameters, forget those that left.

        `nodes` has how many there are of each name: one more means that it was started anew, while
        the one before, killed, lingers on the graph.
        """
        for gone in self._known.keys() - nodes.keys():
            self._retry.pop(gone, None)
            self._services.forget(gone)
            if self._by_node.pop(gone, None) is not None:
                self._changed()
        now = self._clock.monotonic()
        for name, count in nodes.items():
            known = name in self._by_node and count <= self._known.get(name, count)
            known = known or name in self._loading or now < self._retry.get(name, (0.0, 0.0))[0]
            if not known and f"{name}/list_parameters" in offered:
                self._loading.add(name)
                self._task(self._load, name)
        self._known = dict(nodes)
        for node, names in self._polling.due(now, self._by_node):
            if node in self._by_node:  # not of those that left in this round
                self._task(self._refresh, node, names)

    async def _refresh(self, node: str, names: list[str]) -> None:
        known = self._by_node.get(node, {})
        # those without a value are told of when they get one
        names = [name for name in names if name in known and known[name].value is not None]
        got = await self._values(node, names) if names else {}
        if got is None or node not in self._by_node:
            return
        if len(got) != len(names):
            self._by_node.pop(node)  # another set of parameters: load all of it
            return
        for name, value in got.items():
            self._take(node, name, value)

    async def _values(self, node: str, names: list[str]) -> dict[str, Any] | None:
        """The values of these; none of them when one has none. None: no answer."""
        got = await self._services.call(
            srv.GetParameters, f"{node}/get_parameters", srv.GetParameters.Request(names=names)
        )
        if got is None:
            return None
        whole = len(got.values) == len(names)
        return {n: as_python(v) for n, v in zip(names, got.values, strict=True)} if whole else {}

    def _task(self, function: Callable[..., Any], *arguments: Any) -> None:
        self._node.executor.create_task(function, *arguments)  # type: ignore[union-attr]

    async def _load(self, node: str) -> None:
        try:
            listed = await self._services.call(
                srv.ListParameters,
                f"{node}/list_parameters",
                srv.ListParameters.Request(),
                once=True,
            )
            names = list(listed.result.names) if listed is not None else []
            described = await self._services.call(
                srv.DescribeParameters,
                f"{node}/describe_parameters",
                srv.DescribeParameters.Request(names=names),
                once=True,
            )
            got = await self._values(node, names)
            if got == {} and names:  # one without a value hides all: they are asked for one by one
                got = await self._one_by_one(node, names)
            if listed is None or described is None or got is None:
                _, waited = self._retry.get(node, (0.0, _RETRY / 2))
                wait = min(2 * waited, _LONGEST_RETRY)
                self._retry[node] = self._clock.monotonic() + wait, wait
                return
            self._retry.pop(node, None)
            self._by_node[node] = {
                name: _parameter(node, name, descriptor, got.get(name), self._secrets.fit(name))
                for name, descriptor in zip(names, described.descriptors, strict=False)
            }
            self._changed()
        finally:
            self._loading.discard(node)

    async def _one_by_one(self, node: str, names: list[str]) -> dict[str, Any] | None:
        found: dict[str, Any] = {}
        for name in names:
            got = await self._values(node, [name])
            if got is None:
                return None
            found |= got
        return found

    async def set(self, node: str, values: Mapping[str, Any], gate: Gate) -> Outcome:
        """Set values (of the Python types that fit), all or none; the node's reason if it refuses.

        The outcome says what the node answers when it is asked for them afterwards.
        """
        before = self._texts(node, values)
        try:
            parameters = [self._message(node, name, value) for name, value in values.items()]
        except ValueError as error:
            return Outcome(Code.MISUSE, str(error))
        request = srv.SetParametersAtomically.Request(parameters=parameters)
        answer = await self._services.call(
            srv.SetParametersAtomically,
            f"{node}/set_parameters_atomically",
            request,
            gate=gate,
        )
        if answer is None:
            return Outcome(Code.TIMEOUT, f"no answer in {services.DEADLINE:g} s from {node}")
        if not answer.result.successful:
            reason = self._secrets.without(answer.result.reason, values)
            return Outcome(Code.REFUSED, reason or "refused, no reason given")
        names = list(values)
        got = await self._services.call(
            srv.GetParameters, f"{node}/get_parameters", srv.GetParameters.Request(names=names)
        )
        for name, value in zip(names, got.values if got is not None else (), strict=False):
            self._take(node, name, as_python(value))
        now = self._texts(node, values)
        said = ", ".join(f"{name} is {now[name]}, was {before[name]}" for name in names)
        return Outcome(Code.DONE, said)

    def _texts(self, node: str, names: Iterable[str]) -> dict[str, str]:
        """Return the values as events have them."""
        known = self._secrets.masked({name: self._value(node, name) for name in names})
        return {name: text_of(value) for name, value in known.items()}

    def _message(self, node: str, name: str, value: Any) -> Any:
        """A parameter with a value of the type that it has here. Raises ValueError."""
        known = self._by_node.get(node, {}).get(name)
        if value == [] and known is not None:  # of any type, and only the declared one is taken
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
        known = self._by_node.get(node, {}).get(name)
        return None if known is None else known.value

    def _on_event(self, event: ParameterEvent) -> None:
        for message in event.changed_parameters:
            old, new = self._value(event.node, message.name), as_python(message.value)
            if old is not None and not same(old, new):
                self._told(event.node, message.name, old, new)
        for message in (*event.new_parameters, *event.changed_parameters):
            self._take(event.node, message.name, as_python(message.value))
        for message in event.deleted_parameters:
            if self._by_node.get(event.node, {}).pop(message.name, None) is not None:
                self._changed()

    def _take(self, node: str, name: str, value: Any) -> None:
        known = self._by_node.get(node, {}).get(name)
        if known is None:
            if node in self._by_node and node not in self._loading:
                self._by_node.pop(node)  # declared later: load the whole node
        elif not same(known.value, value):
            self._by_node[node][name] = known._replace(value=value)
            self._changed()
            self._set_anew(node, known.value, value)


def without_secrets(message: ParameterEvent, secrets: SecretNames) -> ParameterEvent:
    """Return a message that was received, with MASK in place of the secret values in it."""
    parts = (message.new_parameters, message.changed_parameters, message.deleted_parameters)
    if not any(secrets.fit(parameter.name) for part in parts for parameter in part):
        return message
    masked = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=MASK)
    new, changed, deleted = (
        [
            ParameterMessage(name=one.name, value=masked) if secrets.fit(one.name) else one
            for one in part
        ]
        for part in parts
    )
    return ParameterEvent(
        stamp=message.stamp,
        node=message.node,
        new_parameters=new,
        changed_parameters=changed,
        deleted_parameters=deleted,
    )


def _parameter(
    node: str, name: str, descriptor: Any, value: Any, is_secret: bool = False
) -> Parameter:
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
        is_secret=is_secret,
    )
