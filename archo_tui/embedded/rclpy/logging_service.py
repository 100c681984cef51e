"""The module `rclpy.logging_service`: services that show and set levels of loggers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rcl_interfaces import srv
from rcl_interfaces.msg import LoggerLevel, SetLoggerLevelsResult
from rclpy import logging

if TYPE_CHECKING:
    from rclpy.node import Node


class LoggingService:
    """The services `~/get_logger_levels` and `~/set_logger_levels`, which a new object offers."""

    def __init__(self, node: Node) -> None:
        node.create_service(srv.GetLoggerLevels, "~/get_logger_levels", self._get)
        node.create_service(srv.SetLoggerLevels, "~/set_logger_levels", self._set)

    def _get(self, request: Any, response: Any) -> Any:
        response.levels = [
            LoggerLevel(name=name, level=int(logging.get_logger_level(name)))
            for name in request.names
        ]
        return response

    def _set(self, request: Any, response: Any) -> Any:
        results = []
        for wanted in request.levels:
            result = SetLoggerLevelsResult(successful=True)
            try:
                logging.set_logger_level(wanted.name, wanted.level)
            except ValueError:
                reason = "Failed reason: Invalid logger level."
                result = SetLoggerLevelsResult(successful=False, reason=reason)
            results.append(result)
        response.results = results
        return response
