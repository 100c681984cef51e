"""The module `rclpy.lifecycle.managed_entity`: entities that follow their node's state."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

from rclpy.lifecycle._states import LifecycleState, TransitionCallbackReturn

__all__ = ["ManagedEntity", "SimpleManagedEntity", "TransitionCallbackReturn"]

_SUCCESS = TransitionCallbackReturn.SUCCESS


class ManagedEntity:
    """An entity whose callbacks are called at its node's transitions.

    A callback gets the state before the transition, and returns how the transition went. The
    callbacks of this class do nothing and return SUCCESS.
    """

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Configure the entity; the node was `unconfigured`."""
        return _SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Clean the entity up; the node was `inactive`."""
        return _SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Shut the entity down; the node was in any state but `finalized`."""
        return _SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Activate the entity; the node was `inactive`."""
        return _SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Deactivate the entity; the node was `active`."""
        return _SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Handle an ERROR of another callback, which had got the same `state`.

        SUCCESS leads to `unconfigured`, any other outcome to `finalized`.
        """
        return _SUCCESS


class SimpleManagedEntity(ManagedEntity):
    """An entity that knows if it has been activated with its node; at first it is not.

    An entity that is added to an active node must wait for the next activation.
    """

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
        """Return True from `on_activate` until `on_deactivate`, whatever other transitions come."""
        return self._enabled

    @staticmethod
    def when_enabled(
        wrapped: Callable[..., None] | None = None,
        *,
        when_not_enabled: Callable[..., None] | None = None,
    ) -> Any:
        """Decorate a method so that it runs only while `is_activated`, and returns None."""

        def decorate(method: Callable[..., None]) -> Callable[..., None]:
            @wraps(method)
            def only_when_enabled(self: SimpleManagedEntity, *args: Any, **kwargs: Any) -> None:
                if self._enabled:
                    method(self, *args, **kwargs)
                elif when_not_enabled is not None:
                    when_not_enabled(*args, **kwargs)

            return only_when_enabled

        return decorate if wrapped is None else decorate(wrapped)
