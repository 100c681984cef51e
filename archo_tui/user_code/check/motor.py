"""The checks of the motor's parameters and services."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from archo_tui.robot.messages.types import kinds, load_class
from archo_tui.robot.outcome import Code, outcome_of
from archo_tui.user_code.check.checker import ANSWER, PARAMETERS, SERVICES, CheckedNode, Checker
from archo_tui.user_code.check.tap import Failed, Skipped

_RESET, _STOP = "/reset_encoder", "/emergency_stop"
_RESET_TYPE = "archo_interfaces/srv/ResetEncoder"
# Names of attributes that hold a count of ticks; ticks_per_revolution does not.
_ENCODER_NAME = re.compile("^(?!.*_per_).*(tick|encoder)", re.IGNORECASE)
_TICKS = 15420  # The chapter's value before a reset.


def check_declared(checker: Checker) -> None:
    """Check that both parameters are declared."""
    missing: dict[str, Failed | Skipped] = {}
    for name in ("max_speed", "wheel_radius"):
        try:
            checker.nodes_with(PARAMETERS, name)
        except (Failed, Skipped) as error:
            missing[name] = error
    if len(missing) == 2 and all(isinstance(error, Skipped) for error in missing.values()):
        raise missing["max_speed"]
    hints = [
        f"not declared: {name}: self.declare_parameter({name!r}, value)"
        if isinstance(error, Skipped)
        else str(error)
        for name, error in missing.items()
    ]
    if hints:
        raise Failed("\n".join(hints))


def check_loaded(checker: Checker) -> None:
    """Check that wheel_radius has the value of the checker's file."""
    declared = [node.has["parameters"] for node in checker.nodes()]
    radii = [values["wheel_radius"] for values in declared if "wheel_radius" in values]
    if not radii:
        raise Skipped("no node declares wheel_radius")
    if radii[-1] != checker.radius:
        says = f"wheel_radius is {radii[-1]}, and the file says {checker.radius:g}"
        raise Failed(f"{says}: nothing may set it again")


def check_reset(checker: Checker) -> str | None:
    """Call reset_encoder, and check its type, its answer, and that a number of the node is zero.

    Attributes that look like tick counters are made large before, since zero would not show a
    reset. If nothing shows one, return a title that claims the answer only.
    """
    nodes = checker.nodes_with(SERVICES, _RESET)
    node, where = nodes[0], nodes[0].has["services"][_RESET]["place"]
    fields = {"Response": ["success", "message"]}
    kind = checker.load_type(nodes, SERVICES, _RESET, [_RESET_TYPE], fields)
    numbers = node.has["numbers"]
    counts = {n: type(value)(_TICKS) for n, value in numbers.items() if _ENCODER_NAME.search(n)}
    checker.set_numbers(node, counts)
    answer = _call(checker, nodes, kind, _RESET)
    after = next((n.has["numbers"] for n in checker.nodes() if n.name == node.name), {})
    left = {name: after[name] for name in counts if abs(after.get(name, 0)) >= _TICKS}
    checker.set_numbers(node, {name: numbers[name] for name in left if left[name] == _TICKS})
    if not answer.success or answer.message != "Encoder reset to zero":
        lacks = "" if answer.success else ": set response.success = True"
        raise Failed(f"{where}answered {answer.success}, {answer.message!r}{lacks}")
    # What was set to zero is the encoder's, whatever its name.
    if any(value and not after.get(name, value) for name, value in (numbers | counts).items()):
        return None
    if left and len(left) == len(counts):
        is_left = f"self.{next(iter(left))} is what it was before"
        raise Failed(f"{where}{is_left}: set it to 0 in the callback")
    return "reset_encoder answers True, 'Encoder reset to zero'"


def check_stop(checker: Checker) -> str | None:
    """Call emergency_stop, and check that it answers True; what it stops is not checked.

    If the type tells no success, or the request has fields and was refused (the empty one may not
    be the one that stops), return a title that claims an answer only.
    """
    nodes = checker.nodes_with(SERVICES, _STOP)
    type_name, where = nodes[0].has["services"][_STOP].values()
    kind = load_class(type_name)
    code = outcome_of(_call(checker, nodes, kind, _STOP)).code
    if code is Code.REFUSED and not kinds(kind.Request):
        raise Failed(f"{where}answered False: set response.success = True")
    return None if code is Code.DONE else "emergency_stop answers"


def _call(checker: Checker, nodes: Sequence[CheckedNode], kind: Any, name: str) -> Any:
    """Call a service with an empty request, and return its response."""
    client = checker.node.create_client(kind, name)
    try:
        checker.until(client.service_is_ready, ANSWER, nodes)
        answer = checker.result(client.call_async(kind.Request()), ANSWER, nodes)
    finally:
        checker.node.destroy_client(client)
    if answer is None:
        raise Failed(f"no answer in {ANSWER:g} s{checker.stuck(nodes)}")
    return answer
