"""The list of the operator's parameter changes, which can be undone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from archo_tui.robot.messages.values import same
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.snapshot import Snapshot

if TYPE_CHECKING:
    from archo_tui.robot.robot import Robot

LIMIT = 100  # Changes that are kept.


class Edit(NamedTuple):
    """A change of parameters of one node."""

    node: str
    before: dict[str, Any]
    after: dict[str, Any]


class UndoList:
    """The last 100 changes that can be undone. Used on the event loop only."""

    def __init__(self) -> None:
        self._done: list[Edit] = []
        self._unanswered = 0

    @property
    def is_changing(self) -> bool:
        """True while a change or an undo has no answer, although its event may have arrived."""
        return self._unanswered > 0

    @property
    def edits(self) -> Sequence[Edit]:
        """The changes that can be undone, the oldest first."""
        return self._done

    def restore(self, edits: Iterable[Edit]) -> None:
        """Take over the changes of the process before a restart."""
        self._done = [*edits]

    @property
    def last(self) -> Edit | None:
        """The change that would be undone; None if there is none."""
        return self._done[-1] if self._done else None

    def values_set(self, node: str) -> dict[str, Any]:
        """Return the values that the operator set last on a node and has not undone, by name."""
        return {
            name: value
            for edit in self._done
            if edit.node == node
            for name, value in edit.after.items()
        }

    def disabled_reason(self, snapshot: Snapshot) -> str:
        """Return why nothing can be undone now; "" if the last change can be."""
        if self.is_changing:
            return "a change has no answer yet: undo it when it has"
        if self.last is None:
            return "nothing to undo"
        is_there = any(p.node == self.last.node for p in snapshot.parameters)
        return "" if is_there else f"{self.last.node} has left the graph"

    def changed_since(self, snapshot: Snapshot) -> dict[str, Any]:
        """Return the values that others have set since the last change: undo would lose them."""
        if self.last is None:
            return {}
        now = _values(snapshot, self.last.node)
        after = self.last.after.items()
        return {name: now.get(name) for name, value in after if not same(now.get(name), value)}

    async def set_parameters(self, robot: Robot, node: str, values: dict[str, Any]) -> Outcome:
        """Set parameters of a node, all or none; if that succeeds, add the change to the list."""
        known = _values(robot.snapshot, node)
        missing = ", ".join(name for name in values if name not in known)
        if missing:  # The node has just left.
            return Outcome(Code.NOT_OFFERED, f"{node} does not report {missing} any more")
        last = self.last
        outcome = await self._set(robot, node, values)
        if outcome.ok:
            before = {name: known[name] for name in values} | self._set_since(last, node, values)
            self._done = [*self._done, Edit(node, before, values)][-LIMIT:]
        return outcome

    def _set_since(self, last: Edit | None, node: str, names: Iterable[str]) -> dict[str, Any]:
        """Return the values that changes after `last` have set on a node, by name.

        They were answered while this change waited, so they are its values of before.
        """
        found: dict[str, Any] = {}
        for edit in reversed(self._done):
            if edit is last:
                break
            if edit.node == node:
                found = {name: edit.after[name] for name in names if name in edit.after} | found
        return found

    async def undo(self, robot: Robot, asked: Edit | None = None) -> Outcome:
        """Set back and forget the last change; REFUSED if `asked` is not the last one any more."""
        edit = self.last
        if edit is None:
            return Outcome(Code.REFUSED, "nothing to undo")
        if asked is not None and asked is not edit:
            return Outcome(Code.REFUSED, "another change is the last one now: nothing was undone")
        outcome = await self._set(robot, edit.node, edit.before)
        if outcome.ok:
            # Compared by identity, because other changes may be equal.
            self._done = [done for done in self._done if done is not edit]
        return outcome

    async def _set(self, robot: Robot, node: str, values: dict[str, Any]) -> Outcome:
        self._unanswered += 1
        try:
            return await robot.set_parameters(node, values)
        finally:
            self._unanswered -= 1


def _values(snapshot: Snapshot, node: str) -> dict[str, Any]:
    return {p.name: p.value for p in snapshot.parameters if p.node == node}
