"""What happens to the robot that no console has told of: somebody else did it. Pure."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

from archo_tui.robot.acts import Act
from archo_tui.robot.outcome import Code
from archo_tui.robot.state import Motion
from archo_tui.robot.values import text_of

CLIENT, CONSOLE = "another client", "another console"
# s for a console to say that it was its doing, before and after: STOP waits 3 s for its servers
_PATIENCE = 4.0
_LATE = 20.0  # s after which what was not answered in time may still be done
_GAP = 2.0  # s without a word, after which the robot's node may have been restarted
_MOST = 200  # acts that are kept
# nothing has left; what the robot refuses it may have done in part: one of two servers stops
_NOT_DONE = (Code.CANCELLED, Code.HELD, Code.NOT_OFFERED, Code.WATCHING, Code.MISUSE)


class _Seen(NamedTuple):
    verbs: Collection[str]  # those that may have done it
    said: str
    at: float  # monotonic s
    node: str = ""
    parameter: str = ""

    def is_done_by(self, verbs: Collection[str], arguments: Mapping[str, Any]) -> bool:
        if not set(verbs) & set(self.verbs):
            return False
        values = arguments.get("values")
        named = isinstance(values, Mapping) and self.parameter in values
        return not self.node or (arguments.get("node") == self.node and named)


class Others:
    """Holds what changed against what consoles, this one too, say they did."""

    def __init__(self, commands: Collection[str], services: Mapping[str, Collection[str]]) -> None:
        """`commands` are the verbs of the robot file's own: one of them may zero the count.

        `services` are the verbs by the services that they call: these can be called by name, too.
        By its request one service may stop, and release.
        """
        self._commands, self._services = commands, services
        self._told: deque[tuple[Act, float]] = deque(maxlen=_MOST)
        self._seen: list[_Seen] = []
        self._motion = Motion()
        self.who = CLIENT  # did what no console tells of

    def told(self, act: Act, now: float) -> None:
        """What a console says that it did."""
        if act.code not in _NOT_DONE:
            self._told.append((act, now))

    def motion(
        self, motion: Motion, now: float, restarted: Callable[[], bool] = lambda: False
    ) -> None:
        """Compare how the robot moves now with how it did.

        Args:
            motion: What was received last.
            now: Monotonic time in seconds.
            restarted: Whether another node tells it than before; asked when something changed.
        """
        before, self._motion = self._motion, motion
        if now - (before.received or 0.0) > _GAP:
            return  # it may be another node by now
        seen = []
        if before.stopped is False and motion.stopped:
            seen.append(_Seen(("stop",), f"stopped by {self.who}", now))
        if before.stopped and motion.stopped is False:
            seen.append(_Seen(("release",), f"stop released by {self.who}", now))
        if before.count and motion.count == 0:
            said = f"encoder reset by {self.who}: 0, was {before.count}"
            seen.append(_Seen(self._commands, said, now))
        if seen and not restarted():
            self._seen += seen

    def parameter(self, node: str, name: str, old: Any, new: Any, now: float) -> None:
        """A node says that a parameter has changed."""
        change = f"{text_of(new)}, was {text_of(old)}"
        said = f"{node.lstrip('/')} {name} changed by {self.who}: {change}"
        self._seen.append(_Seen(("set",), said, now, node, name))

    def unexplained(self, now: float) -> list[str]:
        """What was seen a while ago, and is nobody's by now."""
        due = [seen for seen in self._seen if now - seen.at >= _PATIENCE]
        self._seen = [seen for seen in self._seen if now - seen.at < _PATIENCE]
        return [seen.said for seen in due if not self._is_told(seen)]

    def _is_told(self, seen: _Seen) -> bool:
        return any(
            -_PATIENCE <= seen.at - at <= (_LATE if act.code == Code.TIMEOUT else _PATIENCE)
            and seen.is_done_by(self._verbs(act), act.arguments)
            for act, at in self._told
        )

    def _verbs(self, act: Act) -> Collection[str]:
        """Return its verb; of a service that is called by its name those that call it."""
        service = act.arguments.get("service")
        if act.verb != "call" or not isinstance(service, str):
            return (act.verb,)
        return self._services.get(service, (act.verb,))
