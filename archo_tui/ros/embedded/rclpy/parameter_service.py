"""The services through which every node's parameters are read and set."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any

from rcl_interfaces import srv
from rcl_interfaces.msg import SetParametersResult
from rclpy.exceptions import ParameterNotDeclaredException, ParameterUninitializedException
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_parameters

if TYPE_CHECKING:
    from rclpy.node import Node


SERVICES: dict[str, Any] = {  # In a node's namespace, by name.
    "describe_parameters": srv.DescribeParameters,
    "get_parameters": srv.GetParameters,
    "get_parameter_types": srv.GetParameterTypes,
    "list_parameters": srv.ListParameters,
    "set_parameters": srv.SetParameters,
    "set_parameters_atomically": srv.SetParametersAtomically,
}


class ParameterService:
    """The six parameter services of one node, which a new object offers.

    The response to a request that fails is empty, or has results that are not successful.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        for name, srv_type in SERVICES.items():
            callback = getattr(self, f"_{name}")
            node.create_service(
                srv_type, f"{node.get_name()}/{name}", callback, qos_profile=qos_profile_parameters
            )

    def _describe_parameters(self, request: Any, response: Any) -> Any:
        with suppress(ParameterNotDeclaredException):
            response.descriptors = self._node.describe_parameters(request.names)
        return response

    def _get_parameters(self, request: Any, response: Any) -> Any:
        with suppress(ParameterNotDeclaredException, ParameterUninitializedException):
            parameters = self._node.get_parameters(request.names)
            response.values = [parameter.get_parameter_value() for parameter in parameters]
        return response

    def _get_parameter_types(self, request: Any, response: Any) -> Any:
        with suppress(ParameterNotDeclaredException):
            response.types = self._node.get_parameter_types(request.names)
        return response

    def _list_parameters(self, request: Any, response: Any) -> Any:
        response.result = self._node.list_parameters(request.prefixes, request.depth)
        return response

    def _set_parameters(self, request: Any, response: Any) -> Any:
        response.results = [self._try_to_set([message]) for message in request.parameters]
        return response

    def _set_parameters_atomically(self, request: Any, response: Any) -> Any:
        response.result = self._try_to_set(request.parameters)
        return response

    def _try_to_set(self, messages: list[Any]) -> SetParametersResult:
        try:
            return self._node.set_parameters_atomically(
                [Parameter.from_parameter_msg(message) for message in messages]
            )
        except ParameterNotDeclaredException as error:
            return SetParametersResult(successful=False, reason=str(error))
