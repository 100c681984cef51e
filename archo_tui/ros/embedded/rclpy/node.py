"""The module `rclpy.node`: a participant of the graph."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import Any, TypeVar

from rcl_interfaces.msg import Log, ParameterDescriptor, ParameterEvent
from rclpy import (
    _arguments,
    _names,
    _process,
    logging,
)
from rclpy._entity import Destroyable, DestroyableT, Endpoint, Entity, ServiceEnd
from rclpy._graph import Topic
from rclpy._node_parameters import NodeParameters
from rclpy._rclpy_pybind11 import NodeNameNonExistentError, RCLError
from rclpy.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from rclpy.client import Client
from rclpy.clock import Clock, ROSClock
from rclpy.context import Context
from rclpy.duration import Infinite
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.exceptions import NotInitializedException
from rclpy.executors import Executor
from rclpy.logging import LoggingService, RcutilsLogger
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService
from rclpy.publisher import Publisher
from rclpy.qos import (
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    as_profile,
    qos_profile_parameter_events,
    qos_profile_rosout_default,
    qos_profile_services_default,
)
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.time_source import TimeSource
from rclpy.timer import Rate, Timer
from rclpy.topic_endpoint_info import TopicEndpointInfo, TopicEndpointTypeEnum
from rclpy.type_support import check_is_valid_msg_type, check_is_valid_srv_type
from rclpy.utilities import get_default_context

MsgT = TypeVar("MsgT")
T = TypeVar("T")
ServiceEndT = TypeVar("ServiceEndT", bound=ServiceEnd)
NamesAndTypes = list[tuple[str, list[str]]]
_DESCRIBES_TYPES = "start_type_description_service"


class Node(NodeParameters, Destroyable):
    """A named participant with publishers, subscriptions, services, clients, timers, parameters.

    Leaving a `with` destroys the node. Once it is destroyed, also by its context's shutdown,
    methods that ask the graph, add to it, or declare or set parameters raise InvalidHandle.
    """

    def __init__(
        self,
        node_name: str,
        *,
        context: Context | None = None,
        cli_args: Sequence[str] | None = None,
        namespace: str | None = None,
        use_global_arguments: bool = True,
        enable_rosout: bool = True,
        rosout_qos_profile: QoSProfile | int = qos_profile_rosout_default,
        start_parameter_services: bool = True,
        parameter_overrides: Sequence[Parameter[Any]] | None = None,
        allow_undeclared_parameters: bool = False,
        automatically_declare_parameters_from_overrides: bool = False,
        enable_logger_service: bool = False,
    ) -> None:
        self._context = get_default_context() if context is None else context
        if not self._context.ok():
            raise NotInitializedException("cannot create node")
        own = _arguments.parse(cli_args)
        everybodys = self._context._arguments if use_global_arguments else _arguments.Arguments()
        self._remaps = own.remaps + everybodys.remaps
        name = _names.renamed(self._remaps, node_name, "__node", "__name") or node_name
        space = _names.renamed(self._remaps, node_name, "__ns") or namespace or "/"
        space = space if space.startswith("/") else f"/{space}"
        _names.check_node(name, space)
        self._name, self._namespace = name, space
        self._full_name = f"{'' if space == '/' else space}/{name}"
        self._graph = self._context._graph
        self._clock = ROSClock()
        self._logger = RcutilsLogger(self._full_name[1:].replace("/", "."))
        self._executor: Executor | None = None
        self._default_callback_group = MutuallyExclusiveCallbackGroup()
        self._rate_group = ReentrantCallbackGroup()
        self._rosout: Publisher[Log] | None = None
        self._made: list[Any] = []  # Publishers, subscriptions, services, clients, timers.
        with self._graph.changed:
            self._graph.nodes.append(self)
            self._graph.changed.notify_all()
        self._context._nodes.add(self)
        _process.current().add_node(self)

        overrides = everybodys.parameters_of(self._full_name) | own.parameters_of(self._full_name)
        overrides |= {parameter.name: parameter.value for parameter in parameter_overrides or ()}
        self._init_parameters(
            overrides, allow_undeclared_parameters, automatically_declare_parameters_from_overrides
        )
        if enable_rosout and everybodys.rosout_logs and own.rosout_logs:
            self._rosout = self.create_publisher(Log, "/rosout", rosout_qos_profile)
            self._publish_log = self._rosout.publish
            logging.connect(self._logger.name, self._publish_log)
        self._parameter_events = self.create_publisher(
            ParameterEvent, "/parameter_events", qos_profile_parameter_events
        )
        self._time_source = TimeSource(self, self._clock)
        if not self.has_parameter(_DESCRIBES_TYPES):
            # False, where rclpy's default is True: there are no descriptions of types to serve.
            about = "If enabled, start the ~/get_type_description service."
            read_only = ParameterDescriptor(description=about, read_only=True)
            self.declare_parameter(_DESCRIBES_TYPES, False, read_only)
        if self._declare_on_start:
            for parameter, value in overrides.items():
                if not self.has_parameter(parameter):
                    anything = ParameterDescriptor(dynamic_typing=True)
                    self.declare_parameter(parameter, value, anything)
        if start_parameter_services:
            self._parameter_service = ParameterService(self)
        if enable_logger_service:
            self._logging_service = LoggingService(self)

    @property
    def context(self) -> Context:
        """Return the context this node was made in."""
        return self._context

    @property
    def executor(self) -> Executor | None:
        """Return the executor to which this node was added last, or None.

        Setting it removes the node from the one before, and adds it to the new one.
        """
        return self._executor

    @executor.setter
    def executor(self, executor: Executor | None) -> None:
        old = self._executor
        if old is executor:
            return
        if old is not None:
            old.remove_node(self)
        self._executor = executor
        if executor is not None:
            executor.add_node(self)

    def get_name(self) -> str:
        """Return the name without its namespace; raise InvalidHandle once destroyed."""
        self._use()
        return self._name

    def get_namespace(self) -> str:
        """Return the namespace, `/` for the root; raise InvalidHandle once destroyed."""
        self._use()
        return self._namespace

    def get_fully_qualified_name(self) -> str:
        """Return `/namespace/name`; raise InvalidHandle once destroyed."""
        self._use()
        return self._full_name

    def get_clock(self) -> Clock:
        """Return the node's clock, a ROSClock, which follows the parameter `use_sim_time`."""
        return self._clock

    def get_logger(self) -> RcutilsLogger:
        """Return the node's logger, named as the node with dots for slashes: `namespace.name`."""
        return self._logger

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Return a topic's name on the graph: expanded, and remapped unless `only_expand`."""
        try:
            full = self._resolved(topic, only_expand)
        except ValueError as error:
            raise RCLError(f"failed to resolve name: {error}") from None
        problem = _names.full_topic_problem(full)
        if problem:
            raise RCLError(f"failed to resolve name: {problem}")
        return full

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """Return a service's name on the graph: expanded, and remapped unless `only_expand`."""
        return self.resolve_topic_name(service, only_expand=only_expand)

    def _resolved(self, name: str, only_expand: bool = False) -> str:
        """Return a name expanded, and remapped unless `only_expand` is True."""
        self._use()
        full = _names.expand(name, self._name, self._namespace)
        rules = () if only_expand else self._remaps
        return _names.remapped(full, self._name, self._namespace, rules)

    def _validated(self, name: str, *, is_service: bool = False) -> str:
        """Return a name expanded and remapped."""
        _names.check_topic(name, _names.topic_problem(name), is_service=is_service)
        full = self._resolved(name)
        _names.check_topic(full, _names.full_topic_problem(full), is_service=is_service)
        return full

    @property
    def default_callback_group(self) -> CallbackGroup:
        """Return the group, a mutually exclusive one, of entities that are made without a group."""
        return self._default_callback_group

    @property
    def publishers(self) -> Iterator[Publisher[Any]]:
        """Return this node's publishers, without those of its actions and that of /rosout."""
        return (p for p in self._outside_actions(Publisher) if p is not self._rosout)

    @property
    def subscriptions(self) -> Iterator[Subscription[Any]]:
        """Return this node's subscriptions, without those of its actions."""
        return self._outside_actions(Subscription)

    @property
    def services(self) -> Iterator[Service[Any, Any]]:
        """Return this node's services, without those of its actions."""
        return self._outside_actions(Service)

    @property
    def clients(self) -> Iterator[Client[Any, Any]]:
        """Return this node's clients, without those of its actions."""
        return self._outside_actions(Client)

    @property
    def timers(self) -> Iterator[Timer]:
        """Return this node's timers, those of its rates included."""
        return iter(self._all(Timer))

    def create_publisher(
        self,
        msg_type: type[MsgT],
        topic: str,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: PublisherEventCallbacks | None = None,
        publisher_class: type[Publisher[Any]] = Publisher,
    ) -> Publisher[MsgT]:
        """Create a publisher."""
        self._use()
        check_is_valid_msg_type(msg_type)
        name = self._validated(topic)
        publisher = publisher_class(self, msg_type, topic, name, as_profile(qos_profile))
        callbacks = event_callbacks or PublisherEventCallbacks()
        group = callback_group or self._default_callback_group
        publisher.event_handlers = callbacks.create_event_handlers(group, publisher, topic)
        self._made.append(publisher)
        self._graph.add_publisher(publisher)
        return publisher

    def create_subscription(
        self,
        msg_type: type[MsgT],
        topic: str,
        callback: Callable[..., Any],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        raw: bool = False,
    ) -> Subscription[MsgT]:
        """Create a subscription."""
        self._use()
        check_is_valid_msg_type(msg_type)
        group = callback_group or self._default_callback_group
        name = self._validated(topic)
        qos = as_profile(qos_profile)
        subscription: Subscription[MsgT]
        subscription = Subscription(callback, group, raw, self, msg_type, topic, name, qos)
        callbacks = event_callbacks or SubscriptionEventCallbacks()
        subscription.event_handlers = callbacks.create_event_handlers(group, subscription, topic)
        self._made.append(subscription)
        self._graph.add_subscription(subscription)
        return subscription

    def create_client(
        self,
        srv_type: Any,
        srv_name: str,
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Client[Any, Any]:
        """Create a client of a service."""
        table = self._graph.clients
        return self._add(Client, table, srv_type, srv_name, callback_group, qos_profile)

    def create_service(
        self,
        srv_type: Any,
        srv_name: str,
        callback: Callable[[Any, Any], Any],
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Service[Any, Any]:
        """Create a service."""
        make: Any = partial(Service, callback)
        return self._add(
            make, self._graph.services, srv_type, srv_name, callback_group, qos_profile
        )

    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[..., Any],
        callback_group: CallbackGroup | None = None,
        clock: Clock | None = None,
        autostart: bool = True,
    ) -> Timer:
        """Create a timer, which first calls back after a full period.

        Unlike other entities, a timer can also be made on a destroyed node.
        """
        if not self._context.ok():
            raise RCLError("failed to create timer: the given context is not valid")
        group = callback_group or self._default_callback_group
        period_ns = int(float(timer_period_sec) * 1e9)
        timer = Timer(self, callback, group, period_ns, clock or self._clock)
        self._made.append(timer)
        if autostart:
            timer._schedule()
        else:
            timer.cancel()
        return timer

    def create_rate(self, frequency: float, clock: Clock | None = None) -> Rate:
        """Return a rate of that frequency (Hz); another thread must spin the node."""
        if frequency <= 0:
            raise ValueError("frequency must be > 0")
        timer = self.create_timer(1.0 / frequency, lambda: None, self._rate_group, clock)
        return Rate(timer, context=self._context)

    def destroy_rate(self, rate: Rate) -> bool:
        """Destroy a rate and wake its sleepers; return False if the rate is another node's.

        The timer of another node's rate goes on ticking.
        """
        rate.destroy()
        return self.destroy_timer(rate._timer)

    def destroy_publisher(self, entity: Any) -> bool:
        """Destroy a publisher of this node; return False, and do nothing, for another node's."""
        if entity not in self._made:
            return False
        self._made.remove(entity)
        entity.destroy()
        return True

    destroy_subscription = destroy_client = destroy_service = destroy_timer = destroy_publisher

    def _add(
        self,
        make: Callable[..., ServiceEndT],
        table: dict[str, list[Any]],
        srv_type: Any,
        srv_name: str,
        group: CallbackGroup | None,
        qos_profile: QoSProfile,
    ) -> ServiceEndT:
        """Add a client or a service to the node, and to its table of the graph."""
        self._use()
        check_is_valid_srv_type(srv_type)
        name = self._validated(srv_name, is_service=True)
        group = group or self._default_callback_group
        end = make(self, srv_type, srv_name, name, group, qos_profile, table)
        self._made.append(end)
        self._graph.add_named(table, name, end)
        return end

    def _entities(self) -> list[Entity]:
        """Return everything that has callbacks: entities, and the handlers of endpoints' events."""
        endpoints = self._all(Endpoint)
        return [*self._all(Entity), *(event for one in endpoints for event in one.event_handlers)]

    def _all(self, kind: type[T]) -> list[T]:
        return [entity for entity in self._made.copy() if isinstance(entity, kind)]

    def _outside_actions(self, kind: type[DestroyableT]) -> Iterator[DestroyableT]:
        """Yield what was made of a kind, without what an action consists of."""
        return (entity for entity in self._all(kind) if not entity._is_part_of_action)

    def get_node_names(self) -> list[str]:
        """Return the names of all nodes of the domain, this one included, without namespaces."""
        return [name for name, _ in self.get_node_names_and_namespaces()]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        """Return `(name, namespace)` of every node of the domain, this one included."""
        self._use()
        with self._graph.lock:
            return [(node._name, node._namespace) for node in self._graph.nodes]

    def get_fully_qualified_node_names(self) -> list[str]:
        """Return `/namespace/name` of every node of the domain, this one included."""
        self._use()
        with self._graph.lock:
            return [node._full_name for node in self._graph.nodes]

    def get_topic_names_and_types(self, no_demangle: bool = False) -> NamesAndTypes:
        """Return every topic that has a publisher or a subscription, sorted, with its types.

        `no_demangle` has no effect: there are no names of DDS.
        """
        self._use()
        with self._graph.lock:
            return _sorted(
                (name, kind)
                for name, topic in self._graph.topics.items()
                for endpoints in (topic.publishers, topic.subscriptions)
                for kind in {
                    endpoint.msg_type for endpoint in endpoints
                }  # /rosout may have a thousand.
            )

    def get_service_names_and_types(self) -> NamesAndTypes:
        """Return every service that has a server or a client, sorted, with its types.

        `count_services` tells which have a server.
        """
        self._use()
        with self._graph.lock:
            return _sorted(
                (name, endpoint.srv_type)
                for table in (self._graph.services, self._graph.clients)
                for name, endpoints in table.items()
                for endpoint in endpoints
            )

    def get_publisher_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> NamesAndTypes:
        """Return the topics that a node publishes, sorted, with their types.

        Those of actions are included. `no_demangle` has no effect.
        """
        nodes = self._named(node_name, node_namespace)
        return _sorted((p._topic_name, p.msg_type) for node in nodes for p in node._all(Publisher))

    def get_subscriber_names_and_types_by_node(
        self, node_name: str, node_namespace: str, no_demangle: bool = False
    ) -> NamesAndTypes:
        """Return the topics to which a node subscribes; see `get_publisher_...`."""
        nodes = self._named(node_name, node_namespace)
        return _sorted(
            (s._topic_name, s.msg_type) for node in nodes for s in node._all(Subscription)
        )

    def get_service_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> NamesAndTypes:
        """Return the services that a node offers; see `get_publisher_...`."""
        nodes = self._named(node_name, node_namespace)
        return _sorted((s._service_name, s.srv_type) for node in nodes for s in node._all(Service))

    def get_client_names_and_types_by_node(
        self, node_name: str, node_namespace: str
    ) -> NamesAndTypes:
        """Return the services of which a node is a client; see `get_publisher_...`."""
        nodes = self._named(node_name, node_namespace)
        return _sorted((c._service_name, c.srv_type) for node in nodes for c in node._all(Client))

    def get_publishers_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Return a topic's publishers with types and QoS; an empty list for an unknown topic.

        The name is expanded and remapped. As from DDS, history is UNKNOWN and depth 0. `no_mangle`
        has no effect.
        """
        return [_info(endpoint) for endpoint in self._topic(topic_name).publishers]

    def get_subscriptions_info_by_topic(
        self, topic_name: str, no_mangle: bool = False
    ) -> list[TopicEndpointInfo]:
        """Return a topic's subscriptions; see `get_publishers_info_by_topic`."""
        return [_info(endpoint) for endpoint in self._topic(topic_name).subscriptions]

    def count_publishers(self, topic_name: str) -> int:
        """Return how many publishers a topic has; raise ValueError for a bad name.

        Unlike in rclpy, the name is not only expanded but also remapped.
        """
        return len(self._topic(topic_name).publishers)

    def count_subscribers(self, topic_name: str) -> int:
        """Return how many subscriptions a topic has; see `count_publishers`."""
        return len(self._topic(topic_name).subscriptions)

    def count_services(self, service_name: str) -> int:
        """Return how many servers a service has; see `count_publishers`."""
        with self._graph.lock:
            return len(self._graph.services.get(self._resolved(service_name), ()))

    def count_clients(self, service_name: str) -> int:
        """Return how many clients a service has; see `count_publishers`."""
        with self._graph.lock:
            return len(self._graph.clients.get(self._resolved(service_name), ()))

    def _topic(self, name: str) -> Topic:
        """Return the endpoints of a topic now, as copies of the lists."""
        found = Topic()
        with self._graph.lock:
            topic = self._graph.topics.get(self._resolved(name), found)
            found.publishers = topic.publishers.copy()
            found.subscriptions = topic.subscriptions.copy()
        return found

    def _named(self, name: str, namespace: str) -> list[Node]:
        self._use()
        with self._graph.lock:
            nodes = [
                node
                for node in self._graph.nodes
                if node._name == name and node._namespace == namespace
            ]
        if not nodes:
            raise NodeNameNonExistentError(
                f"cannot get names and types for nonexistent node: {name} in {namespace}"
            )
        return nodes

    def destroy_node(self) -> None:
        """Destroy everything this node made and leave the graph; a second call does nothing.

        Its executor still lists the node, and no longer calls it.
        """
        self._leave_graph()
        if self._executor is not None:
            self._executor._drop_work(self)

    destroy = destroy_node  # At the end of a `with`.

    def _leave_graph(self) -> None:
        if self._destroyed:
            return
        self._destroyed = True
        if self._rosout is not None:
            logging.disconnect(self._logger.name, self._publish_log)
        for thing in self._made:
            thing.destroy()
        self._made.clear()
        with self._graph.changed:
            self._graph.nodes.remove(self)
            self._graph.changed.notify_all()


def _sorted(pairs: Iterable[tuple[str, Any]]) -> NamesAndTypes:
    types: dict[str, list[str]] = {}
    for name, kind in pairs:
        known = types.setdefault(name, [])
        if kind.__type_name__ not in known:
            known.append(kind.__type_name__)
            known.sort()
    return sorted(types.items())


def _info(endpoint: Any) -> TopicEndpointInfo:
    node, qos = endpoint._node, as_profile(endpoint.qos_profile)
    qos.history, qos.depth = HistoryPolicy.UNKNOWN, 0  # DDS does not tell these two.
    if qos.liveliness == LivelinessPolicy.SYSTEM_DEFAULT:
        qos.liveliness = LivelinessPolicy.AUTOMATIC
    for name in ("lifespan", "deadline", "liveliness_lease_duration"):
        setattr(qos, name, getattr(qos, name) if getattr(qos, name).nanoseconds else Infinite)
    publishes = isinstance(endpoint, Publisher)
    kind = TopicEndpointTypeEnum.PUBLISHER if publishes else TopicEndpointTypeEnum.SUBSCRIPTION
    type_name = endpoint.msg_type.__type_name__
    return TopicEndpointInfo(
        node_name=node._name,
        node_namespace=node._namespace,
        topic_type=type_name,
        endpoint_type=kind,
        endpoint_gid=list(endpoint._gid),
        qos_profile=qos,
    )
