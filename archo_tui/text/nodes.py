"""The texts of a node that is on the graph, runs in this process, or both. Pure functions."""

from __future__ import annotations

from typing import NamedTuple

from archo_tui.robot.state.graph import NodeInfo, NodeState
from archo_tui.robot.state.snapshot import Hosted, Life, Snapshot
from archo_tui.station.conditions import CONTACT_LOST
from archo_tui.station.view import View
from archo_tui.text.state import OLD, PLAIN, STRONG, Spans, age_text


class NodeRow(NamedTuple):
    """A node as a row of the Nodes panel."""

    state: NodeState  # What the graph and its topics tell of it.
    hosted: Hosted | None  # None for a node of another process.
    # Monotonic time of the last tick, in s; 0 for a node never heard, so that its row does not
    # change each second.
    second: float
    is_lost: bool = False  # No message of the robot arrives.
    publishes: str = ""  # Of the console itself: what a person publishes from it.

    @property
    def name(self) -> str:
        """Return the node's name with its namespace."""
        return self.state.name

    @property
    def is_faulty(self) -> bool:
        """Return True if the node crashed, or could not be restarted: it has left a traceback."""
        hosted = self.hosted
        crashed = hosted is not None and hosted.life == Life.CRASHED
        return crashed or (hosted is not None and hosted.life == Life.UP and bool(hosted.error))

    def word(self) -> tuple[str, str, str]:
        """Return glyph, text and tone of the node's state; no text if all is well."""
        if self.publishes:
            return "▶", f"{self.publishes}, cancel ends it", STRONG
        life = Life.UP if self.hosted is None else self.hosted.life
        if life == Life.CRASHED and self.hosted is not None:
            return "✗", f"crashed: {self.hosted.error}", STRONG
        if life == Life.UP and self.hosted is not None and self.hosted.error:
            return "✗", f"not restarted: {self.hosted.error}", STRONG
        if life == Life.STARTING and self.hosted is not None:
            return "○", f"{life.value}: {self.hosted.error}", PLAIN
        if life == Life.STUCK:
            return "✗", life.value, STRONG
        if life in (Life.STOPPED, Life.ENDED, Life.WAITING):
            return "○", life.value, OLD
        if self.state.is_silent(self.second) and self.state.heard is not None:
            return "?", f"silent for {age_text(self.second - self.state.heard)}", OLD
        if self.is_lost and self.hosted is None:  # The graph may still list it.
            return "?", "contact lost", OLD
        works = self.state.lifecycle in ("", "active")
        return ("●", "", PLAIN) if works else ("○", "", OLD)

    @property
    def label(self) -> str:
        """Return the node's name without its first slash, and the state of a managed node."""
        return f"{self.name.lstrip('/')} {self.state.lifecycle}".rstrip()

    def details(self, now: float, snapshot: Snapshot) -> str:
        """Return the node's state, rate and count of parameters in lines, its traceback last."""
        glyph, word, _ = self.word()
        heard, rate = self.state.heard, self.state.rate
        often = "--" if rate is None else f"{rate:.1f} Hz"
        runs = self.hosted is None or self.hosted.life == Life.UP
        if rate is not None and (self.state.is_silent(now) or not runs):
            often = f"nothing now, {often} before"
        parameters, own = sum(p.node == self.name for p in snapshot.parameters), "the console's"
        lines = [
            f"{glyph} {word or self.state.lifecycle or 'up'}",
            *([f"lifecycle   {self.state.lifecycle}"] if self.state.lifecycle else []),
            f"where       in {'another' if self.hosted is None else own} process",
            f"last heard  {'--' if heard is None else age_text(now - heard) + ' ago'}",
            f"publishes   {often}",
            f"parameters  {parameters}",
        ]
        if self.hosted is not None and self.hosted.traceback:
            lines += ["", self.hosted.traceback.rstrip()]
        return "\n".join(lines)


def graph_lines(info: NodeInfo) -> Spans:
    """Return what a node publishes, subscribes to, serves and calls, each with its type."""
    parts = {
        "topics published": info.publishes,
        "topics subscribed": info.subscribes,
        "services": info.serves,
        "services called": info.calls,
        "actions": info.actions,
        "goals sent to": info.sends,
    }
    width = max((len(name) for names in parts.values() for name, _ in names), default=0)
    spans: list[tuple[str, str]] = []
    for title, names in parts.items():
        if names:
            lines = "".join(f"  {name:<{width}}  {kind}\n" for name, kind in names)
            spans += [(f"{title}\n", OLD), (lines, PLAIN)]
    return tuple(spans) or (("nothing on the graph but what every node has", PLAIN),)


def node_rows(view: View) -> tuple[NodeRow, ...]:
    """Return a row for each node of the graph or of this process, sorted by name."""
    hosted = {node.name: node for node in view.hosted}
    states = {node.name: node for node in view.snapshot.nodes}
    lost = any(alarm.name == CONTACT_LOST and not alarm.is_over for alarm in view.alarms)

    def row(name: str) -> NodeRow:
        state = states.get(name, NodeState(name))
        return NodeRow(state, hosted.get(name), 0.0 if state.heard is None else view.second, lost)

    often: dict[str, str] = {}  # A topic may be published to twice at a time.
    for text in view.publishes:
        name, _, rate = text.partition(", ")
        often[name] = f"{often[name]} and {rate}" if name in often else rate
    ours = [NodeRow(NodeState(name), None, 0.0, publishes=rate) for name, rate in often.items()]
    return (*ours, *map(row, sorted(states.keys() | hosted.keys())))
