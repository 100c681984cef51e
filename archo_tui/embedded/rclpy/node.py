"""`rclpy.node.Node`: a participant of the graph."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any, TypeVar

from rcl_interfaces.msg import Log, ParameterDescriptor, ParameterEvent, SetParametersResult
from rclpy import _arguments, _logging, _names
from rclpy._node_entities import NodeEntities
from rclpy._node_graph import NodeGraph
from rclpy._node_parameters import NodeParameters
from rclpy.clock import Clock, ROSClock
from rclpy.context import Context
from rclpy.exceptions import NotInitializedException
from rclpy.executors import Executor
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService
from rclpy.publisher import Publisher
from rclpy.qos import (
    qos_profile_parameter_events,
    qos_profile_rosout_default,
)
from rclpy.utilities import get_default_context

MsgT = TypeVar("MsgT")


class Node(NodeEntities, NodeParameters, NodeGraph):
    """A named participant with publishers, subscriptions, services, clients, timers, parameters."""

    def __init__(
        self,
        node_name: str,
        *,
        context: Context | None = None,
        cli_args: Sequence[str] | None = None,
        namespace: str | None = None,
        use_global_arguments: bool = True,
        enable_rosout: bool = True,
        start_parameter_services: bool = True,
        parameter_overrides: Sequence[Parameter[Any]] | None = None,
        allow_undeclared_parameters: bool = False,
        automatically_declare_parameters_from_overrides: bool = False,
    ) -> None:
        """Raises NotInitializedException, InvalidNodeNameException, InvalidNamespaceException."""
        self._context = get_default_context() if context is None else context
        if not self._context.ok():
            raise NotInitializedException("cannot create node")
        own = _arguments.parse(cli_args)
        everybodys = self._context._arguments if use_global_arguments else _arguments.Arguments()
        self._remaps = own.remaps + everybodys.remaps
        name = _names.special(self._remaps, node_name, "__node", "__name") or node_name
        space = _names.special(self._remaps, node_name, "__ns") or namespace or "/"
        _names.validate_node_name(name)
        space = space if space.startswith("/") else f"/{space}"
        _names.validate_namespace(space)
        self._name, self._namespace = name, space
        self._graph = self._context._graph
        self._clock: Clock = ROSClock()
        self._logger = RcutilsLogger(self.get_fully_qualified_name()[1:].replace("/", "."))
        self._executor: Executor | None = None
        self._init_entities()
        self._on_graph = True
        with self._graph.changed:
            self._graph.nodes.append(self)
            self._graph.changed.notify_all()
        self._context._nodes.add(self)

        full = self.get_fully_qualified_name()
        overrides = everybodys.parameters_of(full) | own.parameters_of(full)
        overrides |= {parameter.name: parameter.value for parameter in parameter_overrides or ()}
        self._init_parameters(
            overrides, allow_undeclared_parameters, automatically_declare_parameters_from_overrides
        )
        self._rosout: Publisher[Log] | None = None
        if enable_rosout:
            self._rosout = self.create_publisher(Log, "/rosout", qos_profile_rosout_default)
            self._publish_log = self._rosout.publish
            _logging.connect(self._logger.name, self._publish_log)
        self._parameter_events = self.create_publisher(
            ParameterEvent, "/parameter_events", qos_profile_parameter_events
        )
        self.declare_parameter("use_sim_time", False)
        self.add_on_set_parameters_callback(_no_simulated_time)
        if self._declare_on_start:
            for parameter, value in overrides.items():
                if not self.has_parameter(parameter):
                    anything = ParameterDescriptor(dynamic_typing=True)
                    self.declare_parameter(parameter, value, anything)
        if start_parameter_services:
            self._parameter_service = ParameterService(self)

    @property
    def context(self) -> Context:
        """The context this node was made in."""
        return self._context

    @property
    def executor(self) -> Executor | None:
        """The executor that runs this node's callbacks, or None."""
        return self._executor

    @executor.setter
    def executor(self, executor: Executor | None) -> None:
        old, self._executor = self._executor, executor
        if executor is not None and old is not None and old is not executor:
            old.remove_node(self)
            self._executor = executor

    def get_name(self) -> str:
        """The name without its namespace."""
        return self._name

    def get_namespace(self) -> str:
        """The namespace, `/` for the root."""
        return self._namespace

    def get_fully_qualified_name(self) -> str:
        """`/namespace/name`."""
        return f"{'' if self._namespace == '/' else self._namespace}/{self._name}"

    def get_clock(self) -> Clock:
        """The node's clock."""
        return self._clock

    def get_logger(self) -> RcutilsLogger:
        """The node's logger."""
        return self._logger

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """The name on the graph. Raises InvalidTopicNameException."""
        full = _names.expand(topic, self._name, self._namespace)
        rules = () if only_expand else self._remaps
        return _names.remapped(full, self._name, self._namespace, rules)

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """The name on the graph. Raises InvalidServiceNameException."""
        full = _names.expand(service, self._name, self._namespace, is_service=True)
        rules = () if only_expand else self._remaps
        return _names.remapped(full, self._name, self._namespace, rules)

    def destroy_node(self) -> None:
        """Destroy everything this node made and leave the graph."""
        self._leave_graph()
        if self._executor is not None:
            self._executor.remove_node(self)

    def __enter__(self) -> Node:
        return self

    def __exit__(self, *_: object) -> None:
        self.destroy_node()

    def _leave_graph(self) -> None:
        if not self._on_graph:
            return
        self._on_graph = False
        if self._rosout is not None:
            _logging.disconnect(self._logger.name, self._publish_log)
        for thing in itertools.chain(self._publishers, self._entity_list):
            thing.destroy()  # type: ignore[attr-defined]
        self._publishers.clear()
        self._entity_list.clear()
        with self._graph.changed:
            self._graph.nodes.remove(self)
            self._graph.changed.notify_all()


def _no_simulated_time(parameters: list[Parameter[Any]]) -> SetParametersResult:
    if any(p.name == "use_sim_time" and p.value for p in parameters):
        return SetParametersResult(
            successful=False, reason="the embedded engine has no simulated time (use_sim_time)"
        )
    return SetParametersResult(successful=True)
