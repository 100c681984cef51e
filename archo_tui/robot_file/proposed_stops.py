"""The services that may be the STOP of a robot without a file. Pure functions.

None is ever proposed as sure: a person uncomments it. And none is proposed as a plain command,
which could be called without the care that a STOP takes.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from archo_tui.robot_file import known_types
from archo_tui.robot_file.model import StopServices
from archo_tui.robot_file.sighting import Sighting, served_reason


def proposed_stops(
    seen: Sequence[Sighting],
) -> Iterator[tuple[StopServices, str, Sighting]]:
    """Yield an entry for each service that may be the STOP, the reason, and its sighting.

    The entry names the service that may release it, if one is found; a service of a type in the
    table of known STOPs releases itself.
    """
    releases = [s for s in seen if _is_release(s)]
    for sighting in seen:
        if sighting in releases:
            continue
        kind = next((t for t in sighting.types if t in known_types.STOPS), "")
        stop = known_types.STOPS.get(kind, StopServices(""))
        if kind:
            made = replace(stop, service=sighting.name, release=sighting.name)
        else:
            release = _release(sighting, len(seen) - len(releases), releases)
            made = replace(release, service=sighting.name)
        reason = f"{served_reason(sighting)}: is this the STOP? Then uncomment it"
        if not kind and sighting.goal:
            fields = ", ".join(f"{path} ({type_})" for path, type_ in sighting.goal.items())
            reason += f", and say as `request` what is sent: {fields}"
        yield made, reason, sighting


def is_stop(sighting: Sighting) -> bool:
    """Return True for a service that may stop the robot, or release a stop, by type or name."""
    if sighting.kind != "service":
        return False
    return (
        not known_types.STOP_TYPES.isdisjoint(sighting.types)
        or any(word in sighting.name.lower() for word in known_types.STOP_WORDS)
        or not _words(sighting.name).isdisjoint(known_types.STOP_WHOLE_WORDS)
    )


def _is_release(sighting: Sighting) -> bool:
    """Return True if a service may release a stop; only its own name counts, not its namespace."""
    own_name = sighting.name.rpartition("/")[2].lower()
    return any(word in own_name for word in known_types.RELEASE_WORDS)


def _release(stop: Sighting, stops: int, releases: Sequence[Sighting]) -> StopServices:
    """Return an entry with the service that may release a stop, if any; `service` is still empty.

    The service is beside or below the stop, and shares the most words with the stop's name. One
    with further words releases something else: `clear_brake_stop` no emergency stop. If there is
    only one stop and one release there, they belong together.
    """
    beside = stop.name.rpartition("/")[0]
    words = _words(stop.name.removeprefix(beside))
    near = [
        (_words(release.name.removeprefix(beside)) - {*known_types.RELEASE_WORDS}, release)
        for release in releases
        if release.name.rpartition("/")[0] in (beside, stop.name)
    ]
    fitting = [pair for pair in near if pair[0] <= words]
    if not fitting and stops == len(near) == 1:
        fitting = near
    if not fitting:
        return StopServices("")
    _, best = max(fitting, key=lambda pair: len(pair[0]))
    toggle = next((known_types.TOGGLES[t] for t in best.types if t in known_types.TOGGLES), "")
    return StopServices("", release=best.name, release_request={toggle: True} if toggle else {})


def _words(name: str) -> set[str]:
    """Return the words of a name in lower case: of `/softStop/kill_switch` soft, stop, kill ..."""
    parted = re.sub(r"([a-z0-9])([A-Z])", r"\1 \2", name)
    return set(re.findall(r"[a-z]+", parted.lower()))
