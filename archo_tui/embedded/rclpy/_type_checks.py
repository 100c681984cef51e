"""Checks of actions and callbacks that rclpy makes at once, and so this engine does."""

from __future__ import annotations

import contextlib
import inspect
from typing import Any


def check_action(kind: Any) -> None:
    """Raise AttributeError unless `kind` is the class of an action."""
    if not hasattr(kind, "Impl"):
        raise AttributeError(f"{kind!r} has no attribute '_TYPE_SUPPORT': it is no action type")


def takes_info(callback: Any) -> bool:
    """Return True if a callback takes a message and its info, and not a message alone."""
    with contextlib.suppress(TypeError):
        signature = inspect.signature(callback)
        for given in (1, 2):
            with contextlib.suppress(TypeError):
                signature.bind(*[object()] * given)
                return given == 2
    raise RuntimeError(
        "Subscription.__init__(): callback should be either be callable with one argument"
        "(to get only the message) or two (to get message and message info)"
    )
