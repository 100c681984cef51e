"""The lines around the panels: header, alarm banner, footer, and messages over them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from rich.cells import cell_len
from textual.content import Content
from textual.notifications import SeverityLevel
from textual.widgets import Static

from archo_tui.base.clock import time_of_day
from archo_tui.base.safe_text import harmless
from archo_tui.robot.clients import ASSISTANT
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.readings import Battery, Motion
from archo_tui.robot.state.snapshot import Latch, StopAnswer
from archo_tui.screen.widgets.line import click, key_content
from archo_tui.screen.widgets.panel import ScreenState
from archo_tui.station.alarms import Alarm, AlarmState, any_urgent
from archo_tui.station.conditions import Priority
from archo_tui.station.view import View
from archo_tui.text.columns import crop, pad
from archo_tui.text.goal import remaining_text, running_word
from archo_tui.text.state import STILL_MOVING, STILL_RUNNING, elsewhere_text, fixed_width

_MIN_CAUSE = 24  # Cells of an alarm's cause that are kept in a short banner.
_NARROW = 71  # Below so many cells without the clock, panels may be scrolled away.


def header(view: View, width: int) -> Content:
    """Return the robot's name, contact and activity; at the right end, who else is connected.

    If space is short, the names of other consoles are left out first, then the remaining way, the
    right end except for the engine, the engine, and at last the robot's name. Below 71 cells the
    charge of the battery is shown as well.
    """
    doing, left = activity(view)
    watching = "watching" if view.watching and not view.replay else ""
    what = [view.replay, harmless(view.snapshot.file.name), contact(view), watching, doing]
    # The battery's panel may be out of sight.
    if width < _NARROW and view.snapshot.file.battery is not None:
        what.insert(3, f"{fixed_width(view.snapshot.battery.percentage, '.1f')} %")
    assistants = [client for client in view.clients if client.startswith(ASSISTANT)]
    programs = len(view.clients) - len(assistants)
    shells = _count(programs, "shell") if programs else ""
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
                line = Content.assemble((f" {head}", "bold"), f"{' ' * gap}{tail} ")
                return _in_colour(line, doing, view)
    whole = " ".join(filter(None, what))
    if cell_len(whole) >= width:  # The robot's name is the best known.
        del what[1]
        whole = " ".join(filter(None, what))
    engine = f" {view.engine}" if cell_len(f" {whole} {view.engine} ") <= width else ""
    return _in_colour(Content.styled(f" {whole}{engine}", "bold"), doing, view)


def _in_colour(line: Content, doing: str, view: View) -> Content:
    """Return the header with STOPPED in its alarm's colour, and a replay's words reversed."""
    snapshot = view.snapshot
    if view.replay:
        line = line.stylize("reverse", 0, len(view.replay) + 1)
    begin = line.plain.rfind(doing) if doing else -1
    is_doubtful = snapshot.latch is Latch.UNCERTAIN or snapshot.runs_on
    if begin < 0 or not (is_doubtful or snapshot.is_at_rest):
        return line
    is_bad = is_doubtful or snapshot.stop_not_obeyed
    style = "$bad" if is_bad else "$warn"
    return line.stylize(style, begin, begin + len(doing))


def clock(view: View) -> Content:
    """Return the local time of day, `12:04:31 `, so that a frozen screen is noticed."""
    return Content.styled(f"{time_of_day(view.time)} ", "bold")


def banner(view: ScreenState, width: int) -> Content:
    """Return the most important alarm with its advice, and how many others there are.

    An assistant's request takes its place, unless an alarm of high priority is active and
    unacknowledged. An active unacknowledged alarm is reversed over the whole width, but not in a
    replay.
    """
    shown = [alarm for alarm in view.alarms if alarm.state != AlarmState.SHELVED]
    if view.requests and not any_urgent(view.alarms):  # Alarms of high priority come first.
        return _request_banner(view, shown, width)
    names = [alarm.name for alarm in view.alarms if alarm.state == AlarmState.SHELVED]
    shelved = f"shelved: {', '.join(names)}" if names else ""
    if not shown:
        return Content.styled(f" {shelved}" if shelved else "", "$quiet")
    alarm, key = shown[0], view.key("ack")
    more = f"   +{_count(len(shown) - 1, 'alarm')}" if len(shown) > 1 else ""
    more += "   an assistant asks" if view.requests else ""
    texts = [
        view.advice(alarm),
        alarm.text,
        _without_brackets(alarm.text),
    ]
    if alarm.until is not None:
        texts = [past_alarm(alarm)]
    glyph, hint = alarm.priority.glyph, "" if alarm.acknowledged else f"   ({key})"
    mark = "recorded: " if view.replay else ""  # It is no alarm of now.
    room = width - cell_len(f" {mark}{glyph} {more}{hint}")
    text = next((text for text in texts if cell_len(text) <= room), texts[-1])
    if cell_len(text) > room + cell_len(hint):  # Without the hint the text may fit.
        text = _shorten_cause(text, room)
    line = f" {mark}{glyph} {text}{more}"
    if shelved:
        whole = f"{line}   {shelved}"
        line = whole if len(whole) <= width else f"{line}   {len(names)} shelved"
    if alarm.acknowledged:
        return Content(line)
    style = "bold $bad" if alarm.priority == Priority.HIGH else "bold $warn"
    shown_line = Content.styled(line, style)
    words = f"({view.key_to_press('ack')} acknowledge)"
    words = words if len(line) + len(words) + 3 <= width else f"({key})"
    if key and cell_len(f"{line}   {words}") <= width:
        shown_line = Content.assemble(shown_line, "   ", _clickable(words, "ack"))
    if alarm.until is not None or view.replay:
        return shown_line
    # Across the whole width while the cause lasts and nobody has acknowledged it.
    gap = " " * max(width - shown_line.cell_length, 0)
    return Content.assemble(shown_line, gap).stylize(f"{style} reverse")


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s'[: number > 1]}"


def is_banner_needed(view: View) -> bool:
    """Return True if the banner shows a request or an alarm, so that nothing may cover it."""
    return bool(view.requests) or any(a.state != AlarmState.SHELVED for a in view.alarms)


def past_alarm(alarm: Alarm) -> str:
    """Return `was: STOPPED, since 12:04:31, over at 12:05:02`, without the end while active."""
    text = f"was: {alarm.short_text}, since {time_of_day(alarm.since)}"
    return text if alarm.until is None else f"{text}, over at {time_of_day(alarm.until)}"


def _clickable(text: str, command: str) -> Content:
    return Content.styled(text, "u").stylize(click(f"command('{command}')"))


def _request_banner(view: ScreenState, alarms: list[Alarm], width: int) -> Content:
    """Return `? assistant 4711 asks: go to shelf 12   (A answer, 57 s)   ▲ low battery`."""
    request, key = view.requests[0], view.key_to_press("alarms")
    others = len(view.requests) - 1
    more = f"   +{_count(others, 'request')}" if others else ""
    more += "".join(f"   {alarm.priority.glyph} {alarm.name}" for alarm in alarms[:1])
    hint = f"({key} answer, {request.seconds_left(view.now):.0f} s)"
    room = width - cell_len(f" ?    {hint}{more}")
    question = crop(harmless(f"{request.requester.source} asks: {request.text}"), max(room, 1))
    answer = _clickable(hint, "alarms")
    return Content.assemble((f" ? {question}", "bold $warn"), "   ", answer, more)


def _without_brackets(text: str) -> str:
    """Return an alarm's text without what stands in brackets before the first colon."""
    what, colon, to_do = text.partition(": ")
    return f"{re.sub(r' [(][^()]*[)]', '', what)}{colon}{to_do}"


def _shorten_cause(text: str, room: int) -> str:
    """Return an alarm's text cut in the middle of its cause, so that the advice stays whole."""
    what, colon, to_do = text.partition(": ")
    left = room - cell_len(f"{colon}{to_do}")
    return f"{pad(what, left)}{colon}{to_do}" if left >= _MIN_CAUSE else crop(text, room)


class FooterKey(NamedTuple):
    """A command in the footer."""

    command: str  # The command's id.
    key: str  # The key as a person reads it.
    word: str
    blocked: bool  # It cannot run now, and is darker.
    everywhere: bool  # The key works in dialogs and while typing as well.


def footer_keys(commands: Iterable[FooterKey]) -> Content:
    """Return all keys with their words, in their order; a click on one runs its command."""
    return Content("").join(
        Content.assemble(" ", key_content(c.command, c.key, c.word, blocked=c.blocked), " ")
        for c in commands
    )


def footer(
    commands: Iterable[FooterKey],
    width: int,
    palette_key: str,
    field_keys: Iterable[tuple[str, str]] = (),  # The focused field's keys, each with its word.
) -> Content:
    """Return the keys of the footer, and at its right end the palette's key if there is room."""
    own = [Content.assemble(" ", (key, "bold"), f" {word} ") for key, word in field_keys]
    rest = footer_keys(commands)
    while own and sum(one.cell_length for one in (*own, rest)) > width:  # STOP's key stays
        own.pop(1 if len(own) > 2 else -1)  # And escape, which leads to the panels.
    made = Content("").join([*own, rest])
    shown = key_content("palette", palette_key, "palette", blocked=False)
    palette = Content.assemble(shown, " ")
    gap = width - made.cell_length - palette.cell_length
    return Content.assemble(made, " " * gap, palette) if gap > 0 else made


def contact(view: View) -> str:
    """Return the contact to the robot: `● online`, or what is silent, and for how many seconds."""
    if view.is_restarting:
        return "? the console restarts"
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
        elsewhere = elsewhere_text(snapshot)
        return f"? {elsewhere}" if elsewhere else "? waiting for data"
    silent = [name for name in heard if readings[name].is_old(view.now)]
    if len(silent) == len(heard):
        return f"✗ no contact, {min(heard.values()):.0f} s"
    if silent:
        return f"▲ {silent[0]} silent, {heard[silent[0]]:.0f} s"
    goal = snapshot.goal
    if goal is not None and goal.phase == Phase.LOST:
        return f"▲ {goal.kind.action} silent, {view.now - (goal.heard or goal.sent):.0f} s"
    return "● online"


def activity(view: View) -> tuple[str, str]:
    """Return what the robot does, and how far to go, as `("MOVING to 12", "9.0 m left")`."""
    snapshot, goal = view.snapshot, view.snapshot.running_goal
    stop = "" if snapshot.has_stop else "no STOP"
    if snapshot.open_stop is not None and snapshot.open_stop.answer is not StopAnswer.AWAITED:
        return f"✗ STOP {snapshot.open_stop.answer.value}", ""
    if snapshot.latch is Latch.UNCERTAIN:
        return "✗ STOP NOT CERTAIN", ""
    if snapshot.runs_on:
        return (STILL_MOVING if snapshot.stop_not_obeyed else STILL_RUNNING), ""
    if snapshot.is_at_rest:
        return (STILL_MOVING if snapshot.stop_not_obeyed else "✗ STOPPED"), ""
    if goal is None:
        return stop, ""
    does = running_word(goal) if goal.phase in (Phase.SENT, Phase.MOVING) else goal.word
    return f"{does}   {stop}".rstrip(), remaining_text(goal)


MAX_ROWS = 3
# Seconds; a warning is a refusal, which also goes when its cause ends.
DURATIONS: dict[SeverityLevel, float] = {"information": 5, "warning": 8, "error": 12}
_LOOKS = {"information": ("·", ""), "warning": ("▲", "bold $warn"), "error": ("✗", "bold $bad")}


class Notice(NamedTuple):
    """A message to the operator."""

    text: str
    severity: SeverityLevel
    until: float  # Monotonic time, in s.
    still_holds: Callable[[], object] = lambda: True  # False once the cause of a refusal is over.


def with_newest(notices: Sequence[Notice], new: Notice) -> list[Notice]:
    """Return the notices to show with a new one, the newest first, in place of an equal one.

    Of more than MAX_ROWS, the oldest of the least grave goes.
    """
    others = [notice for notice in notices if notice.text != new.text]
    if len(others) == MAX_ROWS:
        others.remove(min(reversed(others), key=lambda notice: DURATIONS[notice.severity]))
    return [new, *others]


def notice_text(notices: Sequence[Notice], width: int) -> Content:
    """Return ` ▲ dock: the robot is stopped`, a row each; one alone has up to three rows."""
    lines, room = [], max(width - 4, 8)  # A blank, the glyph and a blank; one at the end.
    for notice in notices:
        glyph, style = _LOOKS[notice.severity]
        rows = [row.plain for row in Content(harmless(notice.text)).wrap(room)]
        most = MAX_ROWS if len(notices) == 1 else 1
        rows = [*rows[: most - 1], " ".join(rows[most - 1 :])]
        text = "\n   ".join(crop(row, room) for row in rows if row)
        lines.append(Content.styled(f" {glyph} {text}", style))
    return Content("\n").join(lines)


class NoticeLine(Static):
    """The notices, drawn over the other widgets of a main screen."""

    _shown: tuple[Sequence[Notice], int] = (), 0
    rows = 1  # Of the text.

    def show(self, notices: Sequence[Notice], width: int) -> None:
        """Show notices, or (none) what lies beneath."""
        if (notices, width) != self._shown:
            self._shown = notices, width
            text = notice_text(notices, width)
            self.rows = text.plain.count("\n") + 1
            self.update(text)
            self.display = bool(notices)
