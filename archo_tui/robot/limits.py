"""The limits of goals that are parameters of a node: why the number of one is not known."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from os.path import basename

from archo_tui.robot.state import Parameter, in_namespace, linked_number
from archo_tui.robot.values import text_of
from archo_tui.robot_file.model import ParameterRef, RobotFile
from archo_tui.safe_text import harmless

# Seconds that a limit must be unknown before this is reported: nodes start one after the other.
_SURE = 5.0


class Limits:
    """The limits in the robot file that refer to parameters, and which of them were reported."""

    def __init__(self, robot: RobotFile) -> None:
        self._links = [
            (kind.action, given.label or path, name, link, basename(link.where))
            for kind in robot.goals
            for path, given in kind.form.items()
            for name, link in (("lower", given.low), ("upper", given.high))
            if isinstance(link, ParameterRef)
        ]
        self._since: dict[str, float] = {}  # Monotonic seconds since when it is unknown, by text.
        self._reported: set[str] = set()  # Texts.

    def unknown_limits(
        self,
        now: float,
        offered: Collection[str],
        namespace: str,
        nodes: Collection[str],
        parameters: Iterable[Parameter],
    ) -> Iterator[tuple[str, str]]:
        """Yield a level and a text for each limit whose number is not known, once per reason.

        A limit is left out until it was unknown for five seconds, and while the action of its goal
        has no server. The level is WARN for a value that is no number, else INFO, as no node is
        obliged to have the parameter. A reason that ended and comes again is reported again.

        Args:
            now: Monotonic time in seconds.
            offered: The services and actions of the robot file that have a server.
            namespace: The robot's namespace.
            nodes: The full names of the nodes on the graph.
            parameters: All parameters that nodes report.
        """
        reported = tuple(parameters)
        found, levels = dict[str, float](), dict[str, str]()
        for action, label, name, link, where in self._links:
            why, level = (
                _unknown_reason(namespace, nodes, reported, link) if action in offered else ("", "")
            )
            if why:
                limit = f"{label} has no {name} limit yet"
                if link.otherwise is not None:
                    limit = f"{label} has the {name} limit {link.otherwise:g}"
                text = f"{limit}: {why} ({where})"
                found[text], levels[text] = self._since.get(text, now), level
        self._since, self._reported = found, self._reported & found.keys()
        for text, since in found.items():
            if now - since >= _SURE and text not in self._reported:
                self._reported.add(text)
                yield levels[text], text


def _unknown_reason(
    namespace: str, nodes: Collection[str], parameters: Iterable[Parameter], link: ParameterRef
) -> tuple[str, str]:
    """Return why a reference to a parameter leads to no number, and the level of that event.

    Both are "" if it leads to one.
    """
    node = in_namespace(namespace, link.node)
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
    if linked_number(own.values(), namespace, sure) is None:
        value = harmless(text_of(own[link.parameter].value))
        return f"{link.parameter} of {name} is {value[:20]}, not a number", "WARN"
    return "", ""
