"""The texts of topics, services and actions, with the nodes that offer them. Pure functions."""

from __future__ import annotations

from typing import NamedTuple

from archo_tui.robot.state.graph import TOPIC, Resource, TopicEnd, TopicInfo
from archo_tui.ros_names import base_name
from archo_tui.station.view import View
from archo_tui.text.state import OLD, PLAIN, WARN, Spans

SILENT = "silent"


class ResourceRow(NamedTuple):
    """A topic, service or action as a row of the Graph panel."""

    resource: Resource
    rate: str = ""  # `1.0 Hz`, `1.0 of 2 Hz` or SILENT for a topic; "" if unknown.

    @property
    def who(self) -> str:
        """Return the nodes that offer the resource, `no publisher`, or `?` for an unknown node."""
        names = ", ".join(node.lstrip("/") for node in self.resource.nodes)
        return names or ("no publisher" if self.resource.kind == TOPIC else "?")

    @property
    def types(self) -> str:
        """Return the types of the resource with their packages, separated by commas."""
        return ", ".join(self.resource.types)

    @property
    def short_types(self) -> str:
        """Return the types of the resource without their packages, separated by commas."""
        return ", ".join(map(base_name, self.resource.types))

    @property
    def as_line(self) -> str:
        """Return the row as a line, followed by a line for each QoS or type mismatch."""
        line = f"{self.resource.kind} {self.resource.name} {self.types}, {self.who}"
        line += f", {self.rate}" if self.rate else ""
        return "\n".join([line, *(f"  {mismatch}" for mismatch in self.resource.mismatches)])

    @property
    def details(self) -> str:
        """Return kind and name, types and nodes of the resource, each in a line, for a dialog."""
        lines = [
            f"{self.resource.kind:<14}{self.resource.name}",
            f"{'type':<14}{self.types}",
            f"{'served by':<14}{', '.join(self.resource.nodes) or 'nobody'}",
        ]
        return "\n".join(lines)


def topic_lines(info: TopicInfo) -> Spans:
    """Return the mismatches of a topic, then its publishers and subscribers, each with its QoS."""
    parts = {"from": info.publishers, "to": info.subscriptions}
    ends = [end for side in parts.values() for end in side]
    width = max((len(_end_name(end)) for end in ends), default=0)
    has_types = len({end.type for end in ends}) > 1
    types = max((len(end.type) for end in ends), default=0) + 2 if has_types else 0
    spans = [(f"{text}\n", WARN) for text in info.mismatches]
    for title, side in parts.items():
        for number, end in enumerate(side):
            kind = f"{end.type if has_types else '':<{types}}"
            spans.append((f"{'' if number else title:<5}", OLD))
            spans.append((f"{_end_name(end):<{width}}  {kind}{end.qos}\n", PLAIN))
    if not info.publishers:
        spans.append(("no publisher\n", OLD))
    if not info.mismatches and all(parts.values()):
        spans.append(("types and QoS of all of them fit\n", OLD))
    return tuple(spans)


def _end_name(end: TopicEnd) -> str:
    """Return the name of an end's node; a hidden one can only be that of this console."""
    return "(this console)" if "/_" in end.node else end.node


def resource_rows(view: View) -> tuple[ResourceRow, ...]:
    """Return a row for each topic, service and action, in the order of the snapshot."""
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
    expected = view.snapshot.expected_rate(topic)
    of = "" if expected is None else f" of {expected:g}"
    return "" if rate.hertz is None else f"{rate.hertz:.1f}{of} Hz"
