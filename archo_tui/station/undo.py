"""The operator's changes of parameters, and how they are undone."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state import Snapshot
from archo_tui.robot.values import same

if TYPE_CHECKING:
    from archo_tui.robot.client import Robot

LIMIT = 100  # changes that are kept


class Edit(NamedTuple):
    """What parameters of one node were, and what they were set to."""

    node: str
    before: dict[str, Any]
    after: dict[str, Any]


class UndoList:
    """The changes that can be undone, the last one first."""

    def __init__(self) -> None:
        self._done: list[Edit] = []
        self._unanswered = 0

    @property
    def is_changing(self) -> bool:
        """Whether a change has not been answered yet; it may have been seen by its event."""
        return self._unanswered > 0

    @property
    def last(self) -> Edit | None:
        """What would be undone."""
        return self._done[-1] if self._done else None

    def kept(self, node: str) -> dict[str, Any]:
        """What the operator has set of a node and not undone: the last value of each parameter."""
        return {
            name: value
            for edit in self._done
            if edit.node == node
            for name, value in edit.after.items()
        }

    def blocked(self, snapshot: Snapshot) -> str:
        """Why nothing can be undone now, or an empty string."""
        if self.is_changing:
            return "a change has no answer yet: undo it when it has"
        if self.last is None:
            return "nothing to undo"
        there = any(p.node == self.last.node for p in snapshot.parameters)
        return "" if there else f"{self.last.node} has left the graph"

    def changed_since(self, snapshot: Snapshot) -> dict[str, Any]:
        """The values now of what the last change set and somebody else has changed since."""
        if self.last is None:
            return {}
        now = _values(snapshot, self.last.node)
        after = self.last.after.items()
        return {name: now.get(name) for name, value in after if not same(now.get(name), value)}

    async def set_parameters(self, robot: Robot, node: str, values: dict[str, Any]) -> Outcome:
        """Set parameters of a node, all or none, and keep what they were."""
        known = _values(robot.snapshot, node)
        missing = ", ".join(name for name in values if name not in known)
        if missing:  # its node has just left: what it was is not known, and so not to be had back
            return Outcome(Code.NOT_OFFERED, f"{node} does not report {missing} any more")
        last = self.last
        outcome = await self._set(robot, node, values)
        if outcome.ok:
            before = {name: known[name] for name in values} | self._set_since(last, node, values)
            self._done = [*self._done, Edit(node, before, values)][-LIMIT:]
        return outcome

    def _set_since(self, last: Edit | None, node: str, names: Iterable[str]) -> dict[str, Any]:
        """What changes behind that one, that were answered meanwhile, have set."""
        found: dict[str, Any] = {}
        for edit in reversed(self._done):
            if edit is last:
                break
            if edit.node == node:
                found = {name: edit.after[name] for name in names if name in edit.after} | found
        return found

    async def undo(self, robot: Robot, asked: Edit | None = None) -> Outcome:
        """Set the parameters of the last change to what they were, if it is the one `asked` for."""
        edit = self.last
        if edit is None:
            return Outcome(Code.REFUSED, "nothing to undo")
        if asked is not None and asked is not edit:  # the answer was about that one
            return Outcome(Code.REFUSED, "another change is the last one now: nothing was undone")
        outcome = await self._set(robot, edit.node, edit.before)
        if outcome.ok:
            self._done = [one for one in self._done if one is not edit]  # others may be equal
        return outcome

    async def _set(self, robot: Robot, node: str, values: dict[str, Any]) -> Outcome:
        self._unanswered += 1
        try:
            return await robot.set_parameters(node, values)
        finally:
            self._unanswered -= 1


def _values(snapshot: Snapshot, node: str) -> dict[str, Any]:
    return {p.name: p.value for p in snapshot.parameters if p.node == node}
