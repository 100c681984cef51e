"""The module `rclpy.lifecycle.managed_entity`: entities that follow their node's state."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

from rclpy.lifecycle._states import LifecycleState, TransitionCallbackReturn

__all__ = ["ManagedEntity", "SimpleManagedEntity", "TransitionCallbackReturn"]

_SUCCESS = TransitionCallbackReturn.SUCCESS


class ManagedEntity:
    """An entity that is told of its node's transitions; each callback returns how it went."""

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Configure, from the state `unconfigured`."""
        return _SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Clean up, from the state `inactive`."""
        return _SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Shut down, from any state but `finalized`."""
        return _SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Activate, from the state `inactive`."""
        return _SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Deactivate, from the state `active`."""
        return _SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle an error of another callback.

        SUCCESS leads to `unconfigured`, any other outcome to `finalized`.
        """
        return _SUCCESS


class SimpleManagedEntity(ManagedEntity):
    """An entity that knows if its node is active."""

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
        """Return True while the node is active."""
        return self._enabled

    @staticmethod
    def when_enabled(
        wrapped: Callable[..., None] | None = None,
        *,
        when_not_enabled: Callable[..., None] | None = None,
    ) -> Any:
        """Wrap a method so that it runs only while the node is active, and returns nothing.

        Otherwise `when_not_enabled` is called, if given, with the arguments without the entity.
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
