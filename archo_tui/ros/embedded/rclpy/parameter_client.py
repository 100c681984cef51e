"""The module `rclpy.parameter_client`: another node's parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from rclpy import _time_source
from rclpy.callback_groups import CallbackGroup
from rclpy.parameter import Parameter
from rclpy.parameter_service import SERVICES
from rclpy.qos import QoSProfile, qos_profile_services_default
from rclpy.task import Future

if TYPE_CHECKING:
    from rclpy.node import Node


Parameters = Sequence[Any]
DoneCallback = Callable[[Future[Any]], Any] | None  # Called with the future when it is done.


class AsyncParameterClient:
    """A client of a remote node's parameter services.

    Each request returns a future of the service's response; a `callback` is called with the future
    when it is done. Without the remote node the future stays pending.
    """

    def __init__(
        self,
        node: Node,
        remote_node_name: str,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> None:
        self.remote_node_name = remote_node_name
        self.node = node
        self._clients: dict[str, Any] = {
            name: node.create_client(
                srv_type,
                f"{remote_node_name}/{name}",
                qos_profile=qos_profile,
                callback_group=callback_group,
            )
            for name, srv_type in SERVICES.items()
        }

    def services_are_ready(self) -> bool:
        """Return True if the remote node offers all six parameter services."""
        return all(client.service_is_ready() for client in self._clients.values())

    def wait_for_services(self, timeout_sec: float | None = None) -> bool:
        """Block until the remote node offers all six services; return False if not in time."""
        deadline = _time_source.patience_ns(timeout_sec)
        for client in self._clients.values():
            left_ns = None if deadline is None else deadline - _time_source.monotonic_ns()
            if not client.wait_for_service(None if left_ns is None else max(left_ns, 0) / 1e9):
                return False
        return True

    def list_parameters(
        self,
        prefixes: list[str] | None = None,
        depth: int | None = None,
        callback: DoneCallback = None,
    ) -> Future[Any]:
        """Request the names of parameters."""
        return self._call("list_parameters", callback, prefixes=prefixes or [], depth=depth or 0)

    def get_parameters(self, names: list[str], callback: DoneCallback = None) -> Future[Any]:
        """Request values; the response has them in the order of the names.

        If one is not declared, or has no value though its type is static, the response is empty.
        """
        return self._call("get_parameters", callback, names=names)

    def get_parameter_types(self, names: list[str], callback: DoneCallback = None) -> Future[Any]:
        """Request types; see `get_parameters`."""
        return self._call("get_parameter_types", callback, names=names)

    def describe_parameters(self, names: list[str], callback: DoneCallback = None) -> Future[Any]:
        """Request descriptors; see `get_parameters`."""
        return self._call("describe_parameters", callback, names=names)

    def set_parameters(self, parameters: Parameters, callback: DoneCallback = None) -> Future[Any]:
        """Request to set parameters one by one; the response has a result for each.

        `parameters` may be Parameters and messages of rcl_interfaces/Parameter.
        """
        return self._call("set_parameters", callback, parameters=_messages(parameters))

    def set_parameters_atomically(
        self, parameters: Parameters, callback: DoneCallback = None
    ) -> Future[Any]:
        """Request to set all parameters or none; the response has one result."""
        return self._call("set_parameters_atomically", callback, parameters=_messages(parameters))

    def delete_parameters(self, names: Sequence[str], callback: DoneCallback = None) -> Future[Any]:
        """Request to undeclare parameters one by one; the response has a result for each.

        Parameters of a static type are refused, and undeclared ones unless the node allows these.
        """
        return self.set_parameters([Parameter(name) for name in names], callback)

    def _call(self, name: str, callback: DoneCallback, **fields: Any) -> Future[Any]:
        future: Future[Any] = self._clients[name].call_async(SERVICES[name].Request(**fields))
        if callback is not None:
            future.add_done_callback(callback)
        return future


def _messages(parameters: Parameters) -> list[Any]:
    return [p.to_parameter_msg() if isinstance(p, Parameter) else p for p in parameters]
