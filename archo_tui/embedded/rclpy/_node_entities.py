"""The half of `rclpy.node.Node` that makes publishers, subscriptions, services, clients, timers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, TypeVar

from rclpy._entity import Entity
from rclpy.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup
from rclpy.client import Client
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, as_profile, qos_profile_services_default
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Timer

if TYPE_CHECKING:
    from rclpy._graph import Graph
    from rclpy.clock import Clock

MsgT = TypeVar("MsgT")


class NodeEntities:
    """Makes, lists and destroys what a node talks by."""

    _graph: Graph
    _clock: Clock

    def _init_entities(self) -> None:
        self._default_callback_group = MutuallyExclusiveCallbackGroup()
        self._publishers: list[Publisher[Any]] = []
        self._entity_list: list[Entity] = []

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        raise NotImplementedError

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        raise NotImplementedError

    @property
    def default_callback_group(self) -> CallbackGroup:
        """The mutually exclusive group of what is made without one."""
        return self._default_callback_group

    @property
    def publishers(self) -> Iterator[Publisher[Any]]:
        """This node's publishers."""
        return iter(list(self._publishers))

    @property
    def subscriptions(self) -> Iterator[Subscription[Any]]:
        """This node's subscriptions."""
        return (e for e in list(self._entity_list) if isinstance(e, Subscription))

    @property
    def services(self) -> Iterator[Service[Any, Any]]:
        """This node's services."""
        return (e for e in list(self._entity_list) if isinstance(e, Service))

    @property
    def clients(self) -> Iterator[Client[Any, Any]]:
        """This node's clients."""
        return (e for e in list(self._entity_list) if isinstance(e, Client))

    @property
    def timers(self) -> Iterator[Timer]:
        """This node's timers."""
        return (e for e in list(self._entity_list) if isinstance(e, Timer))

    def create_publisher(
        self, msg_type: type[MsgT], topic: str, qos_profile: QoSProfile | int
    ) -> Publisher[MsgT]:
        """Raises InvalidTopicNameException, TypeError, ValueError."""
        qos = as_profile(qos_profile)
        publisher = Publisher(self, msg_type, self.resolve_topic_name(topic), qos)
        self._publishers.append(publisher)
        self._graph.add_publisher(publisher)
        return publisher

    def create_subscription(
        self,
        msg_type: type[MsgT],
        topic: str,
        callback: Callable[[MsgT], Any],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
    ) -> Subscription[MsgT]:
        """Raises InvalidTopicNameException, TypeError, ValueError."""
        qos, group = as_profile(qos_profile), callback_group or self._default_callback_group
        name = self.resolve_topic_name(topic)
        subscription = Subscription(self, msg_type, name, callback, group, qos)
        self._entity_list.append(subscription)
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
        """Raises InvalidServiceNameException."""
        name, group = self.resolve_service_name(srv_name), callback_group
        client: Client[Any, Any] = Client(
            self, srv_type, name, group or self._default_callback_group, qos_profile
        )
        self._entity_list.append(client)
        self._graph.add_named(self._graph.clients, name, client)
        return client

    def create_service(
        self,
        srv_type: Any,
        srv_name: str,
        callback: Callable[[Any, Any], Any],
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Service[Any, Any]:
        """Raises InvalidServiceNameException."""
        return self._add_service(Service, srv_type, srv_name, callback, callback_group, qos_profile)

    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[[], Any],
        callback_group: CallbackGroup | None = None,
        clock: Clock | None = None,
        autostart: bool = True,
    ) -> Timer:
        """A timer of that period in s. Raises ValueError for a negative one."""
        group = callback_group or self._default_callback_group
        period_ns = int(float(timer_period_sec) * 1e9)
        timer = Timer(self, callback, group, period_ns, clock or self._clock)
        self._entity_list.append(timer)
        if autostart:
            timer._schedule()
        else:
            timer.cancel()
        return timer

    def destroy_publisher(self, publisher: Publisher[Any]) -> bool:
        """False when it is not this node's."""
        if publisher not in self._publishers:
            return False
        self._publishers.remove(publisher)
        publisher.destroy()
        return True

    def destroy_subscription(self, subscription: Subscription[Any]) -> bool:
        """False when it is not this node's."""
        return self._destroy(subscription)

    def destroy_client(self, client: Client[Any, Any]) -> bool:
        """False when it is not this node's."""
        return self._destroy(client)

    def destroy_service(self, service: Service[Any, Any]) -> bool:
        """False when it is not this node's."""
        return self._destroy(service)

    def destroy_timer(self, timer: Timer) -> bool:
        """False when it is not this node's."""
        return self._destroy(timer)

    def _add_service(
        self,
        kind: type[Service[Any, Any]],
        srv_type: Any,
        srv_name: str,
        callback: Callable[..., Any],
        group: CallbackGroup | None,
        qos_profile: QoSProfile,
    ) -> Service[Any, Any]:
        name = self.resolve_service_name(srv_name)
        group = group or self._default_callback_group
        service = kind(self, srv_type, name, callback, group, qos_profile)
        self._entity_list.append(service)
        self._graph.add_named(self._graph.services, name, service)
        return service

    def _destroy(self, entity: Any) -> bool:
        if entity not in self._entity_list:
            return False
        self._entity_list.remove(entity)
        entity.destroy()
        return True

    def _entities(self) -> list[Entity]:
        return list(self._entity_list)
