"""The texts of topics, services and actions, with the nodes that offer them. Pure functions."""

from __future__ import annotations

from typing import NamedTuple

from archo_tui.robot.state import TOPIC, Resource, TopicInfo
from archo_tui.ros_names import base_name
from archo_tui.station.view import View
from archo_tui.words.state import OLD, PLAIN, WARN, Spans

SILENT = "silent"


class ResourceRow(NamedTuple):
    """A topic, service or action as a row of the Graph panel.

    Attributes:
        resource: What the graph tells of it.
        rate: `1.0 Hz` or SILENT; "" if the console does not subscribe to it.
    """

    resource: Resource
    rate: str = ""

    @property
    def who(self) -> str:
        """Return the nodes that offer it, without their leading slash."""
        names = ", ".join(node.lstrip("/") for node in self.resource.nodes)
        return names or ("no publisher" if self.resource.kind == TOPIC else "?")

    @property
    def types(self) -> str:
        """Return its types with their packages."""
        return ", ".join(self.resource.types)

    @property
    def short_types(self) -> str:
        """Return its types without their packages."""
        return ", ".join(map(base_name, self.resource.types))

    @property
    def as_line(self) -> str:
        """Return the row as a line, followed by a line for each QoS or type mismatch."""
        line = f"{self.resource.kind} {self.resource.name} {self.types}, {self.who}"
        line += f", {self.rate}" if self.rate else ""
        return "\n".join([line, *(f"  {mismatch}" for mismatch in self.resource.mismatches)])

    @property
    def details(self) -> str:
        """Return everything that is known of it, in lines for a dialog."""
        is_topic = self.resource.kind == TOPIC
        does = "published by" if is_topic else "served by"
        lines = [
            f"{self.resource.kind:<14}{self.resource.name}",
            f"{'type':<14}{self.types}",
            *(f"{does if not n else '':<14}{node}" for n, node in enumerate(self.resource.nodes)),
        ]
        if not self.resource.nodes:
            lines.append(f"{does:<14}nobody")
        if is_topic:
            lines.append(f"{'rate':<14}{self.rate or 'not measured by this console'}")
        return "\n".join(lines)


def topic_lines(info: TopicInfo) -> Spans:
    """Return who publishes and who subscribes, each with type and QoS, and what does not fit."""
    parts = {"publishers": info.publishers, "subscribers": info.subscriptions}
    width = max((len(end.node) for ends in parts.values() for end in ends), default=0)
    types = max((len(end.type) for ends in parts.values() for end in ends), default=0)
    spans: list[tuple[str, str]] = []
    for title, ends in parts.items():
        lines = "".join(f"  {end.node:<{width}}  {end.type:<{types}}  {end.qos}\n" for end in ends)
        spans += [(f"{title}\n", OLD), (lines or "  none\n", PLAIN)]
    if info.mismatches:
        spans.append(("does not fit\n", OLD))
        spans.append(("".join(f"  {text}\n" for text in info.mismatches), WARN))
    elif info.publishers and info.subscriptions:
        spans.append(("types and QoS of all of them fit\n", PLAIN))
    return tuple(spans)


def resource_rows(view: View) -> tuple[ResourceRow, ...]:
    """Return the topics, then the services, then the actions, each sorted by name."""
    return tuple(
        ResourceRow(resource, _rate_text(view, resource.name) if resource.kind == TOPIC else "")
        for resource in view.snapshot.resources
    )


def _rate_text(view: View, topic: str) -> str:
    rate = view.snapshot.message_rates.get(topic)
    if rate is None:
        return ""
    if rate.is_silent(view.second):
        return SILENT
    return "" if rate.hertz is None else f"{rate.hertz:.1f} Hz"
