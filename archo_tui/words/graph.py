"""What is published and served, and by whom. Pure."""

from __future__ import annotations

from typing import NamedTuple

from archo_tui.robot.state import TOPIC, Resource
from archo_tui.station.station import View

SILENT = "silent"


class ResourceRow(NamedTuple):
    """One topic, service or action."""

    resource: Resource
    often: str = ""  # `1.0 Hz` or SILENT; empty: the console does not listen to it

    @property
    def who(self) -> str:
        """The nodes, without the slash that all of them begin with."""
        names = ", ".join(node.lstrip("/") for node in self.resource.nodes)
        return names or ("no publisher" if self.resource.kind == TOPIC else "?")

    @property
    def types(self) -> str:
        """In full."""
        return ", ".join(self.resource.types)

    @property
    def short_types(self) -> str:
        """Without their packages."""
        return ", ".join(name.rpartition("/")[2] for name in self.resource.types)

    @property
    def spoken(self) -> str:
        """The row as one line, and a line for each mismatch below it."""
        line = f"{self.resource.kind} {self.resource.name} {self.types}, {self.who}"
        line += f", {self.often}" if self.often else ""
        return "\n".join([line, *(f"  {said}" for said in self.resource.mismatches)])

    @property
    def details(self) -> str:
        """Everything that is known of it, for reading."""
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
            lines.append(f"{'rate':<14}{self.often or 'not measured by this console'}")
            lines += [f"{'mismatch':<14}{said}" for said in self.resource.mismatches]
        return "\n".join(lines)


def resource_rows(view: View) -> tuple[ResourceRow, ...]:
    """Topics, then services, then actions, each by name."""
    return tuple(
        ResourceRow(resource, _often(view, resource.name) if resource.kind == TOPIC else "")
        for resource in view.snapshot.resources
    )


def _often(view: View, topic: str) -> str:
    pace = view.snapshot.paces.get(topic)
    if pace is None:
        return ""
    if pace.is_silent(view.second):
        return SILENT
    return "" if pace.rate is None else f"{pace.rate:.1f} Hz"
