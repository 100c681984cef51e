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
    """

    node: str
    name: str  # The name of the parameter.
    # `bool`, `integer`, `double` or `string`, one of these followed by `[]`, `byte[]`, or `not
    # set`.
    type: str
    value: Any  # Its value; None if it is not set.
    initial: Any  # The value when it was first seen.
    description: str = ""  # The node's description of it.
    low: float | None = None  # The smallest value allowed; None for any.
    high: float | None = None  # The largest.
    read_only: bool = False  # True if it can only be set when its node starts.
    is_secret: bool = False  # True if its name is that of a secret: only the person sees the value.

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
    """Return the number of the parameter to which a robot file refers."""
    wanted = (in_namespace(namespace, link.node), link.parameter)
    for parameter in parameters:
        if (parameter.node, parameter.name) == wanted:
            found = number(parameter.value, low, high)
            return link.otherwise if found is None else found
    return link.otherwise
