"""A parameter of a node, and the number that the robot file refers to by a parameter."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

from archo_tui.robot.messages.values import number, same
from archo_tui.robot.secret_names import MASK
from archo_tui.robot.state.names import in_namespace
from archo_tui.robot_file.model import ParameterRef

# Why the parameters of a node are not known.
NOT_REPORTED, NO_PARAMETER_SERVICES = (
    "has not reported its parameters",
    "has no parameter services",
)
_FARTHEST = 1e15  # A double has so many digits.


class Parameter(NamedTuple):
    """A parameter of a node, as the node has reported it.

    Recordings have the names of the attributes.

    Attributes:
        node: The full name of the node.
        name: The name of the parameter.
        type: `bool`, `integer`, `double` or `string`, one of these followed by `[]`, `byte[]`, or
            `not set`.
        value: Its value; None if it is not set.
        initial: The value when it was first seen.
        description: The node's description of it.
        low: The smallest value allowed; None for any.
        high: The largest.
        read_only: True if it can only be set when its node starts.
        is_secret: True if its name is that of a secret: only the person sees the value.
    """

    node: str
    name: str
    type: str
    value: Any
    initial: Any
    description: str = ""
    low: float | None = None
    high: float | None = None
    read_only: bool = False
    is_secret: bool = False

    @property
    def masked(self) -> Parameter:
        """The same parameter with MASK in place of its values, if it is secret and has one."""
        if not self.is_secret or self.value is None:
            return self
        return self._replace(value=MASK, initial=MASK)

    @property
    def is_changed(self) -> bool:
        """True if the value differs from the one that was first seen."""
        return not same(self.value, self.initial)


def linked_number(
    parameters: Iterable[Parameter],
    namespace: str,
    link: ParameterRef,
    low: float = -_FARTHEST,
    high: float = _FARTHEST,
) -> float | None:
    """Return the number of the parameter to which a robot file refers.

    Args:
        parameters: All parameters that nodes report.
        namespace: The robot's namespace.
        link: The reference.
        low: The smallest number that is taken.
        high: The largest.

    Returns:
        The number; if no node reports one in this range, the reference's `otherwise`, which may be
        None.
    """
    wanted = (in_namespace(namespace, link.node), link.parameter)
    for parameter in parameters:
        if (parameter.node, parameter.name) == wanted:
            found = number(parameter.value, low, high)
            return link.otherwise if found is None else found
    return link.otherwise
