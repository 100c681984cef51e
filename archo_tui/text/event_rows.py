"""The rows of the list of events, in which nothing is said twice. Pure functions."""

from __future__ import annotations

import re
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

from archo_tui.clock import time_of_day
from archo_tui.robot.outcome import Code
from archo_tui.robot.state.events import OWN_LEVELS, Event
from archo_tui.robot.state.snapshot import Hosted
from archo_tui.text.event import is_of_own_file, one_line_text, outcome_glyph

_REQUESTED = ("YOU", "SHELL", "AI")  # The levels of what this console did, for whomever.
_LINKS = ("is", "to", "at", "the")  # They go with the words that they link to.
_JOINTS = ("and", "or", "but")
_ENDING = re.compile("(ing|ed|es|e|s)$")
_ECHO_TIME = 1.0  # Seconds between what was done and what a node logs of it.


class EventRow(NamedTuple):
    """A row of the list of events."""

    text: str  # Without its time.
    events: tuple[Event, ...]  # It stands for these; the first one gives the row its glyph.
    time: float  # Unix time of the last of them.


class _Act(NamedTuple):
    """A STOP, a release, or something that failed: what nodes may warn of in the same words."""

    time: float  # Unix, s.
    words: frozenset[str]  # Their stems, with those of its command and its code.
    event: Event


def event_rows(events: Sequence[Event], hosted: Sequence[Hosted]) -> list[EventRow]:
    """Return the rows for events, oldest first, in which each outcome is said once.

    A confirmed STOP and its release are one row, in the release's place; a warning that only
    repeats what was done is part of that row.
    """
    warned = sorted(filter(_is_warned, events), key=lambda event: event.time)
    acts = [_Act(e.time, _words(f"{e.text} {e.command} {e.code}"), e) for e in warned]
    echoes: defaultdict[int, list[Event]] = defaultdict(list)  # By the number of the act.
    rows: list[EventRow] = []
    stop: EventRow | None = None  # Of the last one that was confirmed and has no end yet.
    for event in events:
        act = _repeated_act(event, acts, hosted)
        if act is not None:
            echoes[act.number].append(event)
            continue
        done = _verb(event) if event.code == Code.DONE else ""
        if stop is not None and done == "release" and _is_prompt(event):
            rows.remove(stop)
            text = _stop_text(stop.events[0], event)
            rows.append(EventRow(text, (*stop.events, event), event.time))
        else:
            rows.append(EventRow(_short_text(event), (event,), event.time))
        if done in ("stop", "release"):
            stop = rows[-1] if done == "stop" and _is_prompt(event) else None
    return [
        row._replace(events=row.events + tuple(log for e in row.events for log in echoes[e.number]))
        for row in rows
    ]


def without_repeats(text: str) -> str:
    """Return `reset encoder: zero` for `reset encoder: Encoder reset to zero`.

    The first words of the answer go if the request, before the colon, has them in any form; the
    text stays if `and`, `or` or `but` would begin the rest.
    """
    title, _, answer = text.partition(": ")
    known, words = {_stem(word) for word in title.split()}, answer.split()
    repeated = 0  # The number of words that go.
    for number, word in enumerate(words, 1):
        is_link = word.casefold() in _LINKS
        if not repeated and word.lstrip("(+-.")[:1].isdigit():  # `3 retries` of shelf 3.
            break
        if _stem(word) in known or (is_link and 0 < repeated == number - 1):
            repeated = number
        elif not is_link:
            break
    rest = words[repeated:]
    if rest and rest[0] in _JOINTS:  # They join it to what would go.
        return text
    return f"{title}: {' '.join(rest)}" if rest else title


def _verb(event: Event) -> str:
    """Return the verb that an event records; "" if it is not known.

    Recordings do not keep the verb: there its text tells STOP, release and set.
    """
    if event.audit_record is not None:
        return event.audit_record.verb
    titles = (("STOP", "stop"), ("release stop", "release"), ("set ", "set"))
    return next((verb for title, verb in titles if event.text.startswith(title)), "")


def _is_prompt(event: Event) -> bool:
    """Return True if an event tells what this console did, and its answer did not come late."""
    return event.level in _REQUESTED and not _is_late(event)


def _is_late(event: Event) -> bool:
    record = event.audit_record
    is_later = record is not None and bool(record.arguments.get("later"))
    return is_later or ", answered late" in event.text


def _short_text(event: Event) -> str:
    """Return an event's text, without repeats for a goal or for what went as requested."""
    is_done = event.level in OWN_LEVELS and event.code == Code.DONE and not _is_late(event)
    return without_repeats(event.text) if is_done or event.level == "GOAL" else one_line_text(event)


def _stop_text(stop: Event, release: Event) -> str:
    """Return `STOP: confirmed 12:04:31, released: nothing resumes by itself`."""
    by = "" if release.source == stop.source else f" by {release.source}"
    answer = without_repeats(release.text).partition(": ")[2]
    end = f"released{by}: {answer}" if answer else f"released{by}"
    return f"{stop.text} {time_of_day(stop.time)}, {end}"


def _is_warned(event: Event) -> bool:
    """Return True for a STOP, its release, and what failed.

    Setting a parameter is left out: it brings warnings that are news.
    """
    if event.level not in OWN_LEVELS:
        return False
    verb = _verb(event)
    return verb in ("stop", "release") or (verb != "set" and outcome_glyph(event) not in "✓·")


def _repeated_act(event: Event, acts: Sequence[_Act], hosted: Sequence[Hosted]) -> Event | None:
    """Return the act, within a second, that a warning only repeats; None if it has news."""
    if event.level != "WARN" or is_of_own_file(event, hosted):
        return None
    words = _words(event.text)
    begin = bisect_left(acts, event.first - _ECHO_TIME, key=lambda act: act.time)
    end = bisect_left(acts, event.time + _ECHO_TIME, key=lambda act: act.time)
    found = [act.event for act in acts[begin:end] if words <= act.words]
    is_repeat = words and len(found) >= event.count and found[-1].time >= event.time - _ECHO_TIME
    return found[-1] if is_repeat else None


@lru_cache(2048)
def _words(text: str) -> frozenset[str]:
    return frozenset(_stem(word) for word in re.split(r"[^\w.+-]|_", text) if word.strip(".+-"))


def _stem(word: str) -> str:
    """Return a word without ending, capitals and punctuation: `releas` of `Released;`."""
    word = word.strip(",:;()").rstrip(".").rstrip(",:;()").casefold()  # Not the point of `.5`.
    stem = _ENDING.sub("", word)
    return stem if len(stem) > 3 else word
