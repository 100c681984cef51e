"""The services of motor_controller."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from rclpy.node import Node

from archo_tui.chapter import names
from archo_tui.chapter.asker import ANSWER, Asker, CrashedError
from archo_tui.chapter.tap import Result
from archo_tui.hosting.host import HostedNode
from archo_tui.robot import message_classes
from archo_tui.robot.outcome import Code

_RESET = "reset_encoder sets the encoder to zero, and answers True, 'Encoder reset to zero'"
_RESET_ANSWERS = "reset_encoder answers True, 'Encoder reset to zero'"
_STOP = "emergency_stop answers True"
_STOP_ANSWERS = "emergency_stop answers"
_WORDS = "Encoder reset to zero"
# the names of attributes that count; those of a whole turn, ticks_per_revolution, do not
_OF_ENCODERS = re.compile("^(?!.*_per_).*(tick|encoder)", re.IGNORECASE)
_TICKS = 15420  # the chapter's, before a reset
_OWN = ("rcl_interfaces", "type_description_interfaces")  # packages of every node's services


def services(asker: Asker) -> Iterator[Result]:
    """The two checks."""
    yield _service(asker, _RESET, "reset_encoder", _reset)
    yield _service(asker, _STOP, "emergency_stop", _stopped)


def _served(node: Node) -> dict[str, Any]:
    """The services of a node by their names, but for every node's."""
    return {
        service.service_name.lstrip("/"): service
        for service in node.services
        if not service.srv_type.__module__.startswith(_OWN)
        and "/_action/" not in service.service_name
    }


Question = Callable[[Asker, list[HostedNode], Any, str], Result]


def _service(asker: Asker, title: str, name: str, ask: Question) -> Result:
    found = asker.look(_served)
    nodes = [hosted for hosted, services in found.items() if name in services]
    if not nodes:
        others = {f"/{name}" for services in found.values() for name in services}
        return names.missing(asker, title, name, "serve", "service", others)
    made = found[nodes[0]][name].srv_type
    client = asker.node.create_client(made, name)
    try:
        asker.until(client.service_is_ready, ANSWER, nodes)
        where = asker.place_of(found[nodes[0]][name].callback)
        return ask(asker, nodes, client, where)
    except CrashedError as error:
        return Result(title, str(error))
    finally:
        asker.node.destroy_client(client)


def _answer(asker: Asker, nodes: Sequence[HostedNode], client: Any) -> tuple[Any, str]:
    """What a service answers, or why there is no answer."""
    answer = asker.answer(client.call_async(client.srv_type.Request()), nodes)
    if answer is not None:
        return answer, ""
    busy = asker.busy(nodes)
    why = f": a callback does not return, {busy}" if busy else ""
    return None, f"no answer in {ANSWER:g} s{why}"


def _reset(asker: Asker, nodes: list[HostedNode], client: Any, where: str) -> Result:
    named = message_classes.name_of(client.srv_type)
    if named.rpartition("/")[2] != "ResetEncoder":
        called = asker.place_of_text("reset_encoder")
        wrong = f"it is a {named}; the chapter's is an archo_interfaces/srv/ResetEncoder"
        return Result(_RESET, called + wrong)
    before = _numbers(nodes[0].node)
    counters = {name: before[name] for name in before if _OF_ENCODERS.search(name)}
    for name, value in counters.items():
        if abs(value) < _TICKS:  # what is at zero already does not show a reset
            setattr(nodes[0].node, name, type(value)(_TICKS))
    answer, why = _answer(asker, nodes, client)
    after = _numbers(nodes[0].node)
    left = {name: value for name, value in after.items() if name in counters}
    for name, value in left.items():
        if value == _TICKS:
            setattr(nodes[0].node, name, counters[name])
    if answer is None:
        return Result(_RESET, why)
    if not answer.success or answer.message != _WORDS:
        lacks = "" if answer.success else ": set response.success = True"
        return Result(_RESET, f"{where}answered {answer.success}, {answer.message!r}{lacks}")
    if any(before.get(name) and not value for name, value in after.items()):
        return Result(_RESET)  # the one at zero is the encoder's, whatever its name
    if left and all(abs(value) >= _TICKS for value in left.values()):
        kept = next(iter(left))
        wrong = f"{where}self.{kept} is what it was before: set it to 0 in the callback"
        return Result(_RESET, wrong)
    # without an attribute that counts, only the answer was seen
    return Result(_RESET if any(not value for value in left.values()) else _RESET_ANSWERS)


def _numbers(node: Any) -> dict[str, Any]:
    """The attributes of a node that are numbers."""
    return {
        name: value
        for name, value in vars(node).items()
        if isinstance(value, (int, float)) and not isinstance(value, bool)
    }


def _stopped(asker: Asker, nodes: list[HostedNode], client: Any, where: str) -> Result:
    answer, why = _answer(asker, nodes, client)
    if answer is None:
        return Result(_STOP, why)
    code = message_classes.outcome_of(answer).code
    if code is Code.REFUSED and not message_classes.fields(client.srv_type.Request):
        return Result(_STOP, f"{where}answered False: set response.success = True")
    return Result(_STOP if code is Code.DONE else _STOP_ANSWERS)
