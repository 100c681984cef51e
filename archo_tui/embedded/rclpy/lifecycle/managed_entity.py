"""`rclpy.lifecycle.managed_entity`: what follows the state of the node that it belongs to."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

from rclpy.lifecycle._states import LifecycleState, TransitionCallbackReturn

__all__ = ["ManagedEntity", "SimpleManagedEntity", "TransitionCallbackReturn"]

_SUCCESS = TransitionCallbackReturn.SUCCESS


class ManagedEntity:
    """Told of its node's transitions; each callback says how it went."""

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """From the state `unconfigured`."""
        return _SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """From the state `inactive`."""
        return _SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """From any state but `finalized`."""
        return _SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """From the state `inactive`."""
        return _SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """From the state `active`."""
        return _SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Another callback went wrong; SUCCESS leads to `unconfigured`, else to `finalized`."""
        return _SUCCESS


class SimpleManagedEntity(ManagedEntity):
    """Knows whether its node is active."""

    def __init__(self) -> None:
        self._enabled = False

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._enabled = True
        return _SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._enabled = False
        return _SUCCESS

    @property
    def is_activated(self) -> bool:
        """True while the node is active."""
        return self._enabled

    @staticmethod
    def when_enabled(
        wrapped: Callable[..., None] | None = None,
        *,
        when_not_enabled: Callable[..., None] | None = None,
    ) -> Any:
        """A method that does its work only while the node is active, and returns nothing.

        Else `when_not_enabled` is called, if given, with the arguments but for the entity.
        """

        def decorate(method: Callable[..., None]) -> Callable[..., None]:
            @wraps(method)
            def only_when_enabled(self: SimpleManagedEntity, *args: Any, **kwargs: Any) -> None:
                if self._enabled:
                    method(self, *args, **kwargs)
                elif when_not_enabled is not None:
                    when_not_enabled(*args, **kwargs)

            return only_when_enabled

        return decorate if wrapped is None else decorate(wrapped)
