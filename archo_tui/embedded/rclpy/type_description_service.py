"""`rclpy.type_description_service`: of it the parameter that every node has, and no service."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rcl_interfaces.msg import ParameterDescriptor

if TYPE_CHECKING:
    from rclpy.node import Node

START_TYPE_DESCRIPTION_SERVICE_PARAM = "start_type_description_service"


def declare_parameter(node: Node) -> None:
    """False, where rclpy's default is True: this engine has no descriptions of types to serve."""
    if not node.has_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM):
        about = "If enabled, start the ~/get_type_description service."
        descriptor = ParameterDescriptor(description=about, read_only=True)
        node.declare_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM, False, descriptor)
