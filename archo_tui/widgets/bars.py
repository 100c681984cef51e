"""The lines around the panels: header, alarm banner, footer."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

from rich.cells import cell_len
from textual.content import Content

from archo_tui.clock import time_of_day
from archo_tui.robot.asker import ASSISTANT
from archo_tui.robot.state import Battery, Latch, Motion, Phase
from archo_tui.robot.text import harmless
from archo_tui.station.alarms import Alarm, Priority, State, advice, is_grave, ways
from archo_tui.station.station import View
from archo_tui.widgets.keys import click, key_content
from archo_tui.widgets.rows import crop, pad
from archo_tui.widgets.shown import Shown
from archo_tui.words.goal import remaining_text, running_word
from archo_tui.words.state import fixed_width

_WHAT = 24  # cells of what is wrong, at least, in a banner that has no room for all
_TINY = 71  # cells of the header, without the clock, below which panels may be scrolled away


def header(view: View, width: int) -> Content:
    """Which robot, in contact or not, what it does; at the right end who else is here, and where.

    Where there is little room the names of other consoles go first, then the way that is left.
    """
    doing, left = _doing(view)
    watching = view.replay or ("watching" if view.watching else "")
    what = [harmless(view.snapshot.file.name), _contact(view), watching, doing]
    if width < _TINY and view.snapshot.file.battery is not None:  # its panel may be out of sight
        what.insert(2, f"{fixed_width(view.snapshot.battery.percentage, '.1f')} %")
    assistants = [client for client in view.clients if client.startswith(ASSISTANT)]
    programs = len(view.clients) - len(assistants)
    shells = f"{programs} shell{'s'[: programs > 1]}" if programs else ""
    count = f"{len(assistants)} " if len(assistants) > 1 else ""
    asking = f"{count}{ASSISTANT}{'s' if count else ''}" if assistants else ""
    namespace = view.namespace if view.namespace != "/" else ""
    where, others = [asking, shells, view.engine, namespace], view.snapshot.consoles
    count = f"{len(others) + 1} consoles" if others else ""
    named = f"{count}: {', '.join(others)}" if others else ""
    for blanks in ("   ", " "):
        for before, behind in (
            ([*what, left], [named, *where]),
            ([*what, left], [count, *where]),
            (what, [count, *where]),
        ):
            head, tail = (blanks.join(filter(None, texts)) for texts in (before, behind))
            gap = width - cell_len(head) - cell_len(tail) - 2
            if gap >= len(blanks):
                return Content.assemble((f" {head}", "bold"), f"{' ' * gap}{tail} ")
    whole = " ".join(filter(None, what))
    if cell_len(whole) >= width:  # its name is what a person knows best
        what = [view.replay, *(text for text in what[1:] if text != view.replay)]  # no robot of now
        whole = " ".join(filter(None, what))
    engine = f" {view.engine}" if cell_len(f" {whole} {view.engine} ") <= width else ""
    return Content.styled(f" {whole}{engine}", "bold")


def clock(view: View) -> Content:
    """The time of day; a screen whose clock stands still is frozen."""
    return _at(int(view.time))


@lru_cache(maxsize=1)
def _at(time: int) -> Content:
    return Content.styled(f"{time_of_day(time)} ", "bold")


def banner(view: Shown, width: int) -> Content:
    """The alarm that matters most, how many more there are, and which are shelved.

    While there is none, the keys to begin with, for somebody who has sent no goal yet.
    """
    shown = [alarm for alarm in view.alarms if alarm.state != State.SHELVED]
    if view.requests and not is_grave(view.alarms):  # else behind what is worse
        return _request(view, shown, width)
    names = [alarm.name for alarm in view.alarms if alarm.state == State.SHELVED]
    shelved = f"shelved: {', '.join(names)}" if names else ""
    if not shown:
        return Content.styled(f" {shelved}", "$quiet") if shelved else _first_keys(view, width)
    alarm, key = shown[0], view.key("ack")
    more = f"   +{len(shown) - 1} more" if len(shown) > 1 else ""
    more += "   an assistant asks" if view.requests else ""
    keys = {name: f"press {key}" for name, key in view.keys.items() if name not in view.blocked}
    texts = [advice(alarm, ways(view.snapshot, keys)), alarm.text, _terse(alarm.text)]
    if alarm.until is not None:
        text = f"was: {alarm.text.partition(':')[0]}, since {time_of_day(alarm.since)}"
        texts = [f"{text}, over at {time_of_day(alarm.until)}"]
    glyph, hint = alarm.priority.glyph, "" if alarm.acknowledged else f"   ({key})"
    room = width - cell_len(f" {glyph} {more}{hint}")
    text = next((text for text in texts if cell_len(text) <= room), texts[-1])
    if cell_len(text) > room + cell_len(hint):  # else the hint goes, and all is said
        text = _shorter(text, room)
    line = f" {glyph} {text}{more}"
    if shelved:
        whole = f"{line}   {shelved}"
        line = whole if len(whole) <= width else f"{line}   {len(names)} shelved"
    if alarm.acknowledged:
        return Content(line)
    style = "$bad" if alarm.priority == Priority.HIGH else "$warn"
    if not key:
        return Content.styled(line, f"bold {style}")
    words = f"({key} acknowledge)"
    words = words if len(line) + len(words) + 3 <= width else f"({key})"
    if cell_len(f"{line}   {words}") > width:
        return Content.styled(line, f"bold {style}")
    return Content.assemble((line, f"bold {style}"), "   ", _underlined(words, "ack"))


def _underlined(text: str, command: str) -> Content:
    """What runs a command when it is clicked."""
    return Content.styled(text, "u").stylize(click(f"command('{command}')"))


def _request(view: Shown, alarms: list[Alarm], width: int) -> Content:
    """`? assistant 4711 asks: go to shelf 12   (A answer, 57 s)   ▲ low battery`."""
    one, key = view.requests[0], view.key("alarms")
    more = f"   +{len(view.requests) - 1} more" if len(view.requests) > 1 else ""
    more += "".join(f"   {alarm.priority.glyph} {alarm.name}" for alarm in alarms[:1])
    hint = f"({key} answer, {one.left(view.now):.0f} s)"
    room = width - cell_len(f" ?    {hint}{more}")
    said = crop(harmless(f"{one.asker.source} asks: {one.text}"), max(room, 1))
    answer = _underlined(hint, "alarms")
    return Content.assemble((f" ? {said}", "bold $warn"), "   ", answer, more)


def _terse(text: str) -> str:
    """Without what stands in brackets before what to do."""
    what, colon, to_do = text.partition(": ")
    return f"{re.sub(r' [(][^()]*[)]', '', what)}{colon}{to_do}"


def _shorter(text: str, room: int) -> str:
    """What is wrong is cut in its middle, so that what to do stays whole behind the colon."""
    what, colon, to_do = text.partition(": ")
    left = room - cell_len(f"{colon}{to_do}")
    return f"{pad(what, left)}{colon}{to_do}" if left >= _WHAT else crop(text, room)


def _first_keys(view: Shown, width: int) -> Content:
    """`g go to shelf   ? keys   c charge the battery`: the robot file's first ones."""
    robot = view.snapshot.file
    if not view.is_first or view.watching or not robot.goals:
        return Content("")
    words = {"go": robot.goals[0].title.lower(), "help": "keys"}
    given = next((command for command in robot.commands if view.key(command.id)), None)
    if given is not None:
        words[given.id] = (given.help or given.title).partition(",")[0].lower()
    shown: list[Content] = []  # as many as there is room for
    for name, word in words.items():
        if key := view.key(name):
            one = key_content(name, key, word, blocked=name in view.blocked)
            width -= one.cell_length + 3
            if width >= 0:
                shown.append(one)
    return Content.assemble(" ", Content("   ").join(shown)).stylize_before("$quiet")


class FooterKey(NamedTuple):
    """One command of the footer."""

    command: str  # its id
    key: str
    word: str
    blocked: bool  # it cannot run now: darker
    everywhere: bool  # it works in dialogs, too


def footer_keys(commands: Iterable[FooterKey]) -> Content:
    """The keys with their words; each can be clicked."""
    return Content("").join(
        Content.assemble(" ", key_content(c.command, c.key, c.word, blocked=c.blocked), " ")
        for c in commands
    )


def footer(commands: Iterable[FooterKey], width: int, palette_key: str) -> Content:
    """The keys, and the palette's at the right end where there is room for it."""
    made = footer_keys(commands)
    shown = key_content("palette", palette_key, "palette", blocked=False)
    palette = Content.assemble(shown, " ")
    gap = width - made.cell_length - palette.cell_length
    return Content.assemble(made, " " * gap, palette) if gap > 0 else made


def _contact(view: View) -> str:
    snapshot, robot = view.snapshot, view.snapshot.file
    readings: dict[str, Battery | Motion] = {}
    if robot.battery is not None:
        readings[robot.battery.topic] = snapshot.battery
    if robot.motion is not None:
        readings[robot.motion.topic] = snapshot.motion
    heard = {
        name: view.now - reading.received
        for name, reading in readings.items()
        if reading.received is not None
    }
    if not heard:
        others = ", ".join(view.snapshot.elsewhere)
        if others:
            return f"? robots seen: {others}; use --namespace {view.snapshot.elsewhere[0]}"
        return "? waiting for data"
    silent = [name for name in heard if readings[name].is_old(view.now)]
    if len(silent) == len(heard):
        return f"✗ no contact, {min(heard.values()):.0f} s"
    if silent:
        return f"▲ {silent[0]} silent, {heard[silent[0]]:.0f} s"
    goal = snapshot.goal
    if goal is not None and goal.phase == Phase.LOST:
        return f"▲ {goal.kind.action} silent, {view.now - (goal.heard or goal.sent):.0f} s"
    return "● online"


def _doing(view: View) -> tuple[str, str]:
    """What the robot does, and how far it has to go."""
    snapshot, goal = view.snapshot, view.snapshot.running_goal
    stop = "" if snapshot.file.stop is not None else "no STOP"
    if snapshot.latch is Latch.UNCERTAIN:
        return "✗ STOP NOT CERTAIN", ""
    if snapshot.is_at_rest:
        return "✗ STOPPED", ""
    if goal is None:
        return stop, ""
    does = running_word(goal) if goal.phase in (Phase.SENT, Phase.MOVING) else goal.word
    return f"{does}   {stop}".rstrip(), remaining_text(goal)
