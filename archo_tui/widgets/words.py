"""Every state as glyph, word and style, in that order of importance. Pure: state in, text out."""

from __future__ import annotations

from textual.content import Content

from archo_tui.alarms import is_low
from archo_tui.clock import time_of_day
from archo_tui.robot.state import BATTERY, MOTOR, MOVE, Goal, NodeState, Phase, Snapshot

OLD = "dim"
BAD, WARN = "bold $text-error", "bold $text-warning"

_HISTORY_SHOWN = 3


def number(value: float | None, form: str) -> str:
    """A number in its fixed form, or `--` in the same width."""
    text = format(0.0, form)
    return "--".rjust(len(text)) if value is None else format(value, form)


def thousands(value: int | None) -> str:
    """`15 420`."""
    return "--" if value is None else f"{value:,}".replace(",", " ")


def age(seconds: float) -> str:
    """`0.4 s`, `12 s`, `3 min`."""
    if seconds < 10:
        return f"{max(seconds, 0.0):.1f} s"
    return f"{seconds:.0f} s" if seconds < 120 else f"{seconds / 60:.0f} min"


def battery_word(snapshot: Snapshot) -> tuple[str, str, str]:
    """Glyph, word and style for the battery."""
    battery = snapshot.battery
    if battery.received is None:
        return "?", "NO DATA", OLD
    if battery.health == "replace":
        return "✗", "REPLACE", BAD
    if battery.percentage is not None and battery.percentage <= 0:
        return "✗", "EMPTY", BAD
    if battery.charging:
        return "↯", "CHARGING", "bold"
    if is_low(snapshot):
        return "▲", "LOW", WARN
    return "●", "GOOD", ""


def battery_line(snapshot: Snapshot, now: float, width: int) -> Content:
    """`▲ LOW       18.0 % 21.3 V`, or dimmed with its age when that fits into `width` cells."""
    glyph, word, style = battery_word(snapshot)
    battery = snapshot.battery
    charge = f"{number(battery.percentage, '5.1f')} %"
    if battery.received is not None and battery.is_old(now):
        text = f"{glyph} {word:<8} {charge}"
        old = f" (old, {now - battery.received:.0f} s)"
        return Content.styled(text + (old if len(text + old) <= width else " (old)"), OLD)
    volts = f" {number(battery.voltage, '4.1f')} V"
    return Content.assemble((f"{glyph} {word:<8}", style), f" {charge}{volts}")


def battery_trend(snapshot: Snapshot, now: float) -> Content:
    """What the charge does."""
    battery = snapshot.battery
    if battery.received is None:
        offered = BATTERY in snapshot.offered
        return Content.styled(
            "waiting for battery_level" if offered else "not offered by any node", OLD
        )
    if battery.is_old(now):
        return Content.styled(f"last heard {age(now - battery.received)} ago", OLD)
    if battery.charging is None:
        return Content.styled("charging: not reported", OLD)
    return Content("charging" if battery.charging else "discharging")


def gauge(percentage: float | None, threshold: float, width: int) -> str:
    """A bar of `width` cells with eighths, and the threshold's mark where it is not filled."""
    filled = 0.0 if percentage is None else percentage / 100 * width
    whole, rest = int(filled), filled - int(filled)
    cells = ["█"] * whole
    if len(cells) < width:
        cells.append(" ▏▎▍▌▋▊▉"[int(rest * 8)] if int(rest * 8) else "░")
    cells += ["░"] * (width - len(cells))
    mark = min(int(threshold / 100 * width), width - 1)
    cells[mark] = "╎" if cells[mark] != "█" else "┃"
    return "".join(cells[:width])


def motor_line(snapshot: Snapshot, now: float) -> Content:
    """`15 420 ticks   0.80 m/s`."""
    motor = snapshot.motor
    text = f"{thousands(motor.ticks):>9} ticks {number(motor.speed, '4.2f')} m/s"
    return Content.styled(text, OLD if motor.received is None or motor.is_old(now) else "")


def motor_word(snapshot: Snapshot, now: float) -> Content:
    """IDLE, MOVING or STOPPED."""
    motor = snapshot.motor
    if motor.received is None:
        offered = MOTOR in snapshot.offered
        return Content.styled("? NO DATA" if offered else "not offered by any node", OLD)
    if motor.is_old(now):
        return Content.styled(f"? silent, {age(now - motor.received)}", OLD)
    if motor.stopped:
        return Content.styled("✗ STOPPED (R releases)", BAD)
    return Content("▶ MOVING" if motor.moving else "● IDLE")


def goal_line(snapshot: Snapshot, now: float) -> Content:
    """Where the goal stands, in the words of its phase."""
    goal = snapshot.goal
    if goal is None:
        if MOVE not in snapshot.offered:
            return Content.styled("move_to_shelf: not offered by any node", OLD)
        return Content("No goal yet. Press g, type a shelf number, press enter.")
    texts = {
        Phase.SENT: (
            "",
            f"SENT to {goal.shelf}",
            f"waiting for the robot ... {_s(now - goal.sent)}",
        ),
        Phase.REFUSED: (BAD, "✗ REFUSED", goal.message),
        Phase.MOVING: ("bold", f"MOVING to {goal.shelf}", _progress(goal, now)),
        Phase.CANCELLING: (
            "bold",
            "CANCELLING",
            f"asked {_s(now - (goal.cancel_asked or now))} ago",
        ),
        Phase.CANCELLED: (BAD, "✗ CANCELLED", _where_ended(goal)),
        Phase.ARRIVED: ("bold", "✓ ARRIVED", _arrival(goal)),
        Phase.ABORTED: (BAD, "✗ ABORTED", goal.message),
        Phase.UNKNOWN: (
            WARN,
            "? UNKNOWN",
            f"no answer for {_s(now - (goal.heard or goal.sent))}; "
            "the goal may be running (asking again)",
        ),
        Phase.LOST: (
            BAD,
            "✗ LOST",
            f"nothing heard for {_s(now - (goal.heard or now))}; the robot may still be moving",
        ),
    }
    style, word, rest = texts[goal.phase]
    return Content.assemble((f"{word:<14}", style), f" {rest}")


def goal_bar(goal: Goal | None, width: int) -> Content:
    """The way driven: a bar with its number beside it."""
    room = max(width - 8, 4)
    fraction = goal.fraction() if goal is not None else 0.0
    done = int(fraction * room)
    if goal is None or goal.phase in (Phase.SENT, Phase.REFUSED):
        return Content.styled("─" * room + "     --", OLD)
    style = "$primary" if goal.is_running else ""
    return Content.assemble(("━" * done, style), ("─" * (room - done), OLD), f" {fraction:5.0%} ")


def goal_history(history: tuple[Goal, ...]) -> Content:
    """The goals before, newest first."""
    if not history:
        return Content.styled("before: none", OLD)
    return Content.styled("before: " + "   ".join(_ended(g) for g in history[:_HISTORY_SHOWN]), OLD)


def node_line(node: NodeState, now: float, *, with_rate: bool) -> str:
    """`● battery_monitor    0.4 s  1.0 Hz`."""
    heard = "" if node.heard is None else age(now - node.heard)
    rate = f" {node.rate:5.1f} Hz" if node.rate is not None else " " * 9
    name = node.name.lstrip("/")
    return f"● {name:<16} {heard:>6}" + (rate if with_rate else "")


def _s(seconds: float) -> str:
    return f"{max(seconds, 0.0):.1f} s"


def _progress(goal: Goal, now: float) -> str:
    if goal.remaining is None or goal.length is None:
        return f"waiting for the first feedback ... {_s(goal.elapsed(now))}"
    left = goal.seconds_left(now)
    about = "" if left is None else f", about {_s(left)} left"
    return (
        f"{goal.remaining:.1f} m left of {goal.length:.1f} m   "
        f"{_s(goal.elapsed(now))} so far{about}"
    )


def _where_ended(goal: Goal) -> str:
    if goal.remaining is None:
        return goal.message
    return f"{goal.message}, {goal.remaining:.1f} m before shelf {goal.shelf}"


def _arrival(goal: Goal) -> str:
    if goal.length is None:
        return goal.message
    return f"{goal.message}, {goal.length:.1f} m in {_s(goal.elapsed(0.0))}"


def _ended(goal: Goal) -> str:
    at = time_of_day(goal.time)
    if goal.phase == Phase.ARRIVED:
        return f"✓ {goal.shelf} arrived {at}"
    return f"✗ {goal.shelf} {goal.phase.value.lower()} {at}"
