"""The lines around the panels: header, alarm banner, footer."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from rich.cells import cell_len
from textual.content import Content

from archo_tui.alarms import Priority, State, advice, ways
from archo_tui.clock import time_of_day
from archo_tui.goal_text import doing, way_left
from archo_tui.robot.state import Battery, Motion, Phase
from archo_tui.robot.text import harmless
from archo_tui.state_text import number
from archo_tui.station import View
from archo_tui.widgets.shown import Shown

_TINY = 71  # cells of the header, without the clock, below which panels may be scrolled away


def header(view: View, width: int) -> Content:
    """Which robot, in contact or not, what it does; at the right end who else is here, and where.

    Where there is little room the names of other consoles go first, then the way that is left.
    """
    doing, left = _doing(view)
    watching = "watching" if view.watching else ""
    what = [harmless(view.snapshot.robot.name), _contact(view), watching, doing]
    if width < _TINY and view.snapshot.robot.battery is not None:  # its panel may be out of sight
        what.insert(2, f"{number(view.snapshot.battery.percentage, '.1f')} %")
    where, others = [view.engine, view.namespace], view.snapshot.consoles
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
        whole = " ".join(filter(None, what[1:]))
    return Content.styled(f" {whole} {view.engine}", "bold")


def clock(view: View) -> Content:
    """The time of day; a screen whose clock stands still is frozen."""
    return Content.styled(f"{time_of_day(view.time)} ", "bold")


def banner(view: Shown, width: int) -> Content:
    """The alarm that matters most, how many more there are, and which are shelved."""
    shown = [alarm for alarm in view.alarms if alarm.state != State.SHELVED]
    names = [alarm.name for alarm in view.alarms if alarm.state == State.SHELVED]
    shelved = f"shelved: {', '.join(names)}" if names else ""
    if not shown:
        return Content.styled(f" {shelved}", "$quiet")
    alarm, key = shown[0], view.key("acknowledge")
    more = f"   +{len(shown) - 1} more" if len(shown) > 1 else ""
    keys = {name: f"press {key}" for name, key in view.keys.items() if name not in view.blocked}
    text = advice(alarm, ways(view.snapshot.robot, keys))
    if alarm.until is not None:
        text = f"was: {alarm.text.partition(':')[0]}, since {time_of_day(alarm.since)}"
        text += f", over at {time_of_day(alarm.until)}"
    line = f" {alarm.priority.glyph} {text}{more}"
    if shelved:
        whole = f"{line}   {shelved}"
        line = whole if len(whole) <= width else f"{line}   {len(names)} shelved"
    if alarm.acknowledged:
        return Content(line)
    style = "$bad" if alarm.priority == Priority.HIGH else "$warn"
    words = f"({key} acknowledge)"
    words = words if len(line) + len(words) + 3 <= width else f"({key})"
    hint = Content.from_markup(f"   [u][@click=app.command('acknowledge')]{words}[/][/]")
    return Content.assemble((line, f"bold {style}"), hint)


class FooterKey(NamedTuple):
    """One command of the footer."""

    command: str  # its id
    key: str
    word: str
    blocked: bool  # it cannot run now: darker
    everywhere: bool  # it works in dialogs, too


def footer_keys(commands: Iterable[FooterKey]) -> Content:
    """The keys with their words; each can be clicked."""
    parts: list[Content] = []
    for command in commands:
        text = f"[bold]{command.key}[/] {command.word}"
        part = Content.from_markup(f" [@click=app.command('{command.command}')]{text}[/] ")
        parts.append(part.stylize("$off" if command.blocked else ""))
    return Content("").join(parts)


def footer(commands: Iterable[FooterKey], width: int, palette_key: str) -> Content:
    """The keys, and the palette's at the right end where there is room for it."""
    made = footer_keys(commands)
    palette = Content.from_markup(
        f"[@click=app.command('palette')][bold]{palette_key}[/] palette[/] "
    )
    gap = width - made.cell_length - palette.cell_length
    return Content.assemble(made, " " * gap, palette) if gap > 0 else made


def _contact(view: View) -> str:
    snapshot, robot = view.snapshot, view.snapshot.robot
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
    stop = "" if snapshot.robot.stop is not None else "no STOP"
    if snapshot.motion.stopped:
        return "✗ STOPPED", ""
    if goal is None:
        return stop, ""
    does = doing(goal) if goal.phase in (Phase.SENT, Phase.MOVING) else goal.word
    return f"{does}   {stop}".rstrip(), way_left(goal)
