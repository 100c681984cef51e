"""The texts of topics, services and actions, of the nodes that offer them, and of transforms."""

from __future__ import annotations

from typing import NamedTuple

from archo_tui.robot.state.frames import Frame, Transforms, faults
from archo_tui.robot.state.graph import TOPIC, Resource, TopicEnd, TopicInfo
from archo_tui.ros.names import base_name
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


NONE = "no transform: nobody publishes /tf or /tf_static"


def transform_lines(transforms: Transforms, now: float) -> list[str]:
    """Return what is wrong, then a line such as `base_link in odom: 20.0 Hz, 0.1 s old, from a`."""
    wrong = [f"▲ {fault}" for fault in filter(None, [transforms.fault, *faults(transforms, now)])]
    lines = [_line(transforms, frame, now) for frame in sorted(transforms.frames.values())]
    if wrong or lines:
        return [*wrong, *lines]
    nodes = [*transforms.publishers, *transforms.static_publishers]
    return [f"no transform came so far from {', '.join(dict.fromkeys(nodes))}" if nodes else NONE]


def _line(transforms: Transforms, frame: Frame, now: float) -> str:
    age, hertz = frame.age(now), frame.rate.hertz_at(now)
    how = ["static"] if age is None else [f"{age:.1f} s old"]
    if age is not None and frame.rate.is_silent(now):
        how = [f"SILENT for {now - frame.rate.heard:.0f} s"]
    elif age is not None and hertz is not None:
        how = [f"{hertz:.1f} Hz", *how]
    nodes = transforms.publishers_of(frame)
    source = nodes[0] if len(nodes) == 1 else f"one of {', '.join(nodes)}"
    how += [f"from {source}"] if nodes else ["its publisher has left"]
    return f"{frame.name} in {frame.parent}: {', '.join(how)}"
