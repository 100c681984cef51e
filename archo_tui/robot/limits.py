"""Limits of the robot file that a node holds as a parameter: why one of them is not known. Pure."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from os.path import basename

from archo_tui.robot.state import Parameter, in_namespace, linked, node_of
from archo_tui.robot.text import harmless
from archo_tui.robot.values import text_of
from archo_tui.robot_file.model import ParameterRef, RobotFile

_SURE = 5.0  # s that it must be so: nodes and their parameters come one by one


class Limits:
    """Says once of each limit that nobody reports it, and again when it was known meanwhile."""

    def __init__(self, robot: RobotFile) -> None:
        self._links = [
            (kind.action, given.label or path, name, link, basename(link.where))
            for kind in robot.goals
            for path, given in kind.form.items()
            for name, link in (("lower", given.low), ("upper", given.high))
            if isinstance(link, ParameterRef)
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
    ) -> Iterator[tuple[str, str]]:
        """Yield the level and text of each event due; none of a goal whose action nobody offers.

        Only a value that is no number is a warning: a node need not hold the limit.

        Args:
            now: The monotonic time in s.
            offered: The names of the robot file that somebody serves.
            namespace: The robot's.
            nodes: The full names of the nodes on the graph.
            parameters: All that nodes report.
        """
        reported = tuple(parameters)
        found, levels = dict[str, float](), dict[str, str]()
        for action, label, name, link, where in self._links:
            why, level = _why(namespace, nodes, reported, link) if action in offered else ("", "")
            if why:
                limit = f"{label} has no {name} limit yet"
                if link.otherwise is not None:
                    limit = f"{label} has the {name} limit {link.otherwise:g}"
                said = f"{limit}: {why} ({where})"
                found[said], levels[said] = self._since.get(said, now), level
        self._since, self._said = found, self._said & found.keys()
        for said, since in found.items():
            if now - since >= _SURE and said not in self._said:
                self._said.add(said)
                yield levels[said], said


def _why(
    namespace: str, nodes: Collection[str], parameters: Iterable[Parameter], link: ParameterRef
) -> tuple[str, str]:
    """Return why the link leads to no number, and the level of that; empty when it leads to one."""
    node = node_of(link, namespace)
    name = node.removeprefix("/")
    own = {parameter.name: parameter for parameter in parameters if parameter.node == node}
    if not node.startswith(in_namespace(namespace, "")):
        return f"{name} is no node of the namespace {namespace}", "INFO"
    if node not in nodes:
        return f"no node {name} is on the graph", "INFO"
    if not own:
        return f"{name} does not report its parameters", "INFO"
    if link.parameter not in own:
        return f"{name} has no parameter {link.parameter}", "INFO"
    sure = ParameterRef(link.node, link.parameter)
    if linked(own.values(), namespace, sure) is None:
        value = harmless(text_of(own[link.parameter].value))
        return f"{link.parameter} of {name} is {value[:20]}, not a number", "WARN"
    return "", ""
