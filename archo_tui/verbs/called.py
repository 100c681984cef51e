"""`call` on a service of the robot file, which runs the verb that stands for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from archo_tui.robot.messages.typed import as_typed, typed_request
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.station.station import Station
from archo_tui.verbs.base import Verb
from archo_tui.verbs.goals import Go, kind_of
from archo_tui.verbs.graph_names import full_name
from archo_tui.verbs.parse import YES, named
from archo_tui.verbs.services import Call, Give
from archo_tui.verbs.stop import ReleaseStop, StopNow

Called = StopNow | ReleaseStop | Give  # Verbs that call a service of the robot file.
_ACTION_PART = "/_action/"  # Between an action's name and those of its services.


def choose_verb(
    verbs: Mapping[str, Verb], station: Station, word: str, words: Sequence[str]
) -> tuple[Verb, list[str]]:
    """Return the verb for a typed word, and the words that are left for that verb.

    `call SERVICE` on a service of the robot file gives the verb that calls this service, so that it
    asks, refuses and checks as that verb does. Raises ValueError if no single verb is meant.
    """
    verb, rest = named(verbs, word), list(words)
    without_yes = [each for each in rest if each != YES]
    if not isinstance(verb, Call) or not without_yes:
        return verb, rest
    service, *fields = without_yes
    snapshot = station.robot.snapshot
    own = verbs_by_service(verbs, snapshot)
    service = full_name(snapshot, service, {*snapshot.services, *own})
    _refuse_part_of_action(verbs, snapshot, service)
    if service not in own or fields == ["--help"]:  # `call` itself refuses it, and calls nothing.
        return verb, rest
    meant = _pick(own[service], service, fields)
    return meant, [YES] if meant.may_ask and YES in rest else []


def verbs_by_service(verbs: Mapping[str, Verb], snapshot: Snapshot) -> dict[str, list[Called]]:
    """Return `stop`, `release` and the robot file's commands by their service's full name."""
    found: dict[str, list[Called]] = {}
    for verb in verbs.values():
        if isinstance(verb, (StopNow, ReleaseStop, Give)) and verb.service:
            found.setdefault(snapshot.full(verb.service), []).append(verb)
    return found


def _pick(found: Sequence[Called], service: str, fields: Sequence[str]) -> Called:
    """Return the verb whose request has the fields that were typed; ValueError unless one has.

    A STOP without fields is returned whatever was typed; one with fields comes before other verbs
    with the same request.
    """
    stop = next((verb for verb in found if isinstance(verb, StopNow)), None)
    if stop is not None and not stop.request:  # Whatever fields were typed.
        return stop
    asked = next((verb.request for verb in found if verb.request), {})
    if not asked and any(field != "{}" for field in fields):
        raise ValueError(f"{service} takes no field, not {' '.join(fields)}")
    given = typed_request(service, fields, asked)
    meant = [verb for verb in found if verb.request == given]
    if stop is not None and stop in meant:
        return stop
    if len(meant) > 1:
        raise ValueError(f"{service} is called by several: type {_either(meant)}")
    if not meant:
        ways = " or ".join(f"{as_typed(verb.request)} ({verb.id})" for verb in found)
        raise ValueError(f"{service} needs {ways}")
    return meant[0]


def _either(found: Sequence[Verb]) -> str:
    return " or ".join(verb.id for verb in found)


def _refuse_part_of_action(verbs: Mapping[str, Verb], snapshot: Snapshot, service: str) -> None:
    """Raise ValueError for a service by which an action takes or cancels goals."""
    action, _, part = service.partition(_ACTION_PART)
    if part == "cancel_goal":
        raise ValueError(f"{service} is a part of the action {action}: type cancel")
    if part == "send_goal":
        kind = kind_of(snapshot, action)
        goals = [verb for verb in verbs.values() if isinstance(verb, Go) and verb.kind == kind]
        ways = goals[0].id if goals else f"send_goal {action}"
        raise ValueError(f"{service} is a part of the action {action}: type {ways}")
