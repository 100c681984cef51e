"""The checks of motor_controller's services."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from archo_tui.robot.messages.types import kinds, load_class, name_of
from archo_tui.robot.outcome import Code, outcome_of
from archo_tui.ros_names import base_name
from archo_tui.user_code.check import near_names
from archo_tui.user_code.check.check_runner import ANSWER, CheckedNode, CheckRunner, CrashedError
from archo_tui.user_code.check.tap import Result

_RESET = "reset_encoder sets the encoder to zero, and answers True, 'Encoder reset to zero'"
_RESET_ANSWERS = "reset_encoder answers True, 'Encoder reset to zero'"
_STOP = "emergency_stop answers True"
_STOP_ANSWERS = "emergency_stop answers"
_RESET_MESSAGE = "Encoder reset to zero"
# Names of attributes that hold a count of ticks; ticks_per_revolution does not.
_ENCODER_NAME = re.compile("^(?!.*_per_).*(tick|encoder)", re.IGNORECASE)
_TICKS = 15420  # The chapter's value before a reset.
_EVERY_NODES = ("rcl_interfaces", "type_description_interfaces")


def service_checks(runner: CheckRunner) -> Iterator[Result]:
    """Yield the outcome of the two checks of services; the second one stops the robot.

    A check is skipped if no node has its service; it fails if a node has one with a similar name.
    """
    yield _check_service(runner, _RESET, "reset_encoder", _check_reset)
    yield _check_service(runner, _STOP, "emergency_stop", _check_stop_answer)


_ServiceCheck = Callable[[CheckRunner, list[CheckedNode], Any, str], Result]


def _check_service(runner: CheckRunner, title: str, name: str, check: _ServiceCheck) -> Result:
    """Find the nodes that have a service, and return the outcome of a check of it.

    If no node has it, `check` is not called: the outcome is skipped, or failed if a node has a
    service with a similar name. A node that crashes fails the check.
    """
    found = runner.nodes()
    nodes = [node for node in found if name in node.services]
    if not nodes:
        others = {
            f"/{other}"
            for node in found
            for other, service in node.services.items()
            if not service["type"].startswith(_EVERY_NODES) and "/_action/" not in other
        }
        return near_names.missing_result(runner, title, name, "serve", "service", others)
    service = nodes[0].services[name]
    service_class = load_class(service["type"])
    client = runner.node.create_client(service_class, name)
    try:
        runner.spin_until(client.service_is_ready, ANSWER, nodes)
        return check(runner, nodes, client, service["place"])
    except CrashedError as error:
        return Result(title, str(error))
    finally:
        runner.node.destroy_client(client)


def _call(runner: CheckRunner, nodes: Sequence[CheckedNode], client: Any) -> tuple[Any, str]:
    """Call a service with an empty request, and wait ANSWER seconds for the response."""
    answer = runner.wait_for_result(client.call_async(client.srv_type.Request()), nodes)
    if answer is not None:
        return answer, ""
    busy = runner.busy_line(nodes)
    why = f": a callback does not return, {busy}" if busy else ""
    return None, f"no answer in {ANSWER:g} s{why}"


def _check_reset(runner: CheckRunner, nodes: list[CheckedNode], client: Any, where: str) -> Result:
    """Call reset_encoder, and check its type, its answer, and that a counter of the node is zero.

    The answer has to be a success with the chapter's message. Attributes of the first node that
    look like tick counters and are small are set to a large number before, and get their old value
    again if the service leaves that number. Without such attributes, only the answer is checked,
    and the title says so.
    """
    type_name = name_of(client.srv_type)
    if base_name(type_name) != "ResetEncoder":
        called = runner.find_text("reset_encoder")
        wrong = f"it is a {type_name}; the chapter's is an archo_interfaces/srv/ResetEncoder"
        return Result(_RESET, called + wrong)
    before = nodes[0].numbers
    counters = {name: before[name] for name in before if _ENCODER_NAME.search(name)}
    small = {name: value for name, value in counters.items() if abs(value) < _TICKS}
    # A count of zero would not show a reset.
    runner.set_numbers(nodes[0], {name: type(value)(_TICKS) for name, value in small.items()})
    answer, why = _call(runner, nodes, client)
    name_of_node = nodes[0].name
    after = next((node.numbers for node in runner.nodes() if node.name == name_of_node), {})
    left = {name: value for name, value in after.items() if name in counters}
    kept = {name: counters[name] for name, value in left.items() if value == _TICKS}
    runner.set_numbers(nodes[0], kept)
    if answer is None:
        return Result(_RESET, why)
    if not answer.success or answer.message != _RESET_MESSAGE:
        lacks = "" if answer.success else ": set response.success = True"
        return Result(_RESET, f"{where}answered {answer.success}, {answer.message!r}{lacks}")
    if any(before.get(name) and not value for name, value in after.items()):
        return Result(_RESET)  # The attribute set to zero is the encoder's, whatever its name.
    if left and all(abs(value) >= _TICKS for value in left.values()):
        wrong = f"{where}self.{next(iter(left))} is what it was before: set it to 0 in the callback"
        return Result(_RESET, wrong)
    # If no attribute is a counter, the title claims the answer only.
    return Result(_RESET if any(not value for value in left.values()) else _RESET_ANSWERS)


def _check_stop_answer(
    runner: CheckRunner, nodes: list[CheckedNode], client: Any, where: str
) -> Result:
    """Call emergency_stop, and check that it answers True; what it stops is not checked.

    The check passes under another title if the service's type tells no success, or if its request
    has fields and it answers False: the empty request may not be the one that stops.
    """
    answer, why = _call(runner, nodes, client)
    if answer is None:
        return Result(_STOP, why)
    code = outcome_of(answer).code
    if code is Code.REFUSED and not kinds(client.srv_type.Request):
        return Result(_STOP, f"{where}answered False: set response.success = True")
    return Result(_STOP if code is Code.DONE else _STOP_ANSWERS)
