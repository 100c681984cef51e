"""Limits of the robot file that a node holds as a parameter: why one of them is not known. Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from os.path import basename

from archo_tui.robot.state import Parameter, in_namespace, linked
from archo_tui.robot.text import harmless
from archo_tui.robot.values import text_of
from archo_tui.robot_file.model import Link, RobotFile

_SURE = 5.0  # s that it must be so: nodes and their parameters come one by one


class Limits:
    """Says once of each limit that nobody reports it, and again when it was known meanwhile."""

    def __init__(self, robot: RobotFile) -> None:
        self._links = [
            (kind.action, f"{name} of {given.label or path}", link, basename(link.where))
            for kind in robot.goals
            for path, given in kind.form.items()
            for name, link in (("low", given.low), ("high", given.high))
            if isinstance(link, Link)
        ]
        self._since: dict[str, float] = {}  # what is to be said, and since when it is so
        self._said: set[str] = set()

    def unknown(
        self,
        now: float,
        offered: Collection[str],
        namespace: str,
        nodes: Collection[str],
        parameters: Iterable[Parameter],
    ) -> Iterator[str]:
        """What is to be said at `now` (s); nothing of a goal whose action nobody offers."""
        told = tuple(parameters)
        found = {}
        for action, of, link, where in self._links:
            why = _why(namespace, nodes, told, link) if action in offered else ""
            if why:
                used = "" if link.otherwise is None else f": {link.otherwise:g} is used"
                said = f"{of}: {why}{used} ({where})"
                found[said] = self._since.get(said, now)
        self._since, self._said = found, self._said & found.keys()
        for said, since in found.items():
            if now - since >= _SURE and said not in self._said:
                self._said.add(said)
                yield said


def _why(
    namespace: str, nodes: Collection[str], parameters: Iterable[Parameter], link: Link
) -> str:
    """Why the link leads to no number; empty when it leads to one."""
    node = in_namespace(namespace, link.node.lstrip("/"))
    own = {parameter.name: parameter for parameter in parameters if parameter.node == node}
    if node not in nodes:
        return f"no node {node} is on the graph"
    if not own:
        return f"{node} does not report its parameters"
    if link.parameter not in own:
        return f"{node} has no parameter {link.parameter}"
    sure = Link(link.node, link.parameter)
    if linked(own.values(), namespace, sure) is None:
        value = harmless(text_of(own[link.parameter].value))
        return f"{link.parameter} of {node} is {value[:20]}, not a number"
    return ""
