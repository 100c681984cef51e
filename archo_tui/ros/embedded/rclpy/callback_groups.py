"""The rules by which callbacks of a node may run at the same time."""

from __future__ import annotations

import threading
from typing import Any


class CallbackGroup:
    """The base of groups of entities that share a rule about running at the same time."""

    def can_execute(self, entity: Any) -> bool:
        """Return True if the entity's callback may start now, without claiming the group."""
        raise NotImplementedError

    def beginning_execution(self, entity: Any) -> bool:
        """Claim the group for the entity's callback; return False if the group is taken."""
        raise NotImplementedError

    def ending_execution(self, entity: Any) -> None:
        """Release the group that `beginning_execution` claimed."""
        raise NotImplementedError


class ReentrantCallbackGroup(CallbackGroup):
    """A group whose callbacks run whenever a thread is free."""

    def can_execute(self, entity: Any) -> bool:
        return True

    def beginning_execution(self, entity: Any) -> bool:
        return True

    def ending_execution(self, entity: Any) -> None:
        return None


class MutuallyExclusiveCallbackGroup(CallbackGroup):
    """A group that runs one callback at a time; an `async def` holds it while it awaits."""

    def __init__(self) -> None:
        self._active: Any = None
        self._lock = threading.Lock()

    def can_execute(self, entity: Any) -> bool:
        return self._active is None

    def beginning_execution(self, entity: Any) -> bool:
        with self._lock:
            if self._active is not None:
                return False
            self._active = entity
            return True

    def ending_execution(self, entity: Any) -> None:
        assert self._active is entity
        self._active = None
