"""Every state as glyph, word and style, in that order of importance. Pure: state in, text out."""

from __future__ import annotations

from textual.content import Content

from archo_tui.alarms import is_low
from archo_tui.robot.state import BATTERY, MOTOR, Snapshot
from archo_tui.widgets import trend

OLD = "dim"
BAD, WARN = "bold $text-error", "bold $text-warning"


def number(value: float | None, form: str) -> str:
    """A number in its fixed form, or `--` in the same width."""
    text = format(0.0, form)
    return "--".rjust(len(text)) if value is None else format(value, form)


def thousands(value: int | None) -> str:
    """`15 420`."""
    return "--" if value is None else f"{value:,}".replace(",", " ")


def age(seconds: float) -> str:
    """`0.4 s`, `12 s`, `3 min`, `0.2 h`: five characters at most up to 99 hours."""
    if seconds < 9.95:
        return f"{max(seconds, 0.0):.1f} s"
    if seconds < 600:
        return f"{seconds:.0f} s" if seconds < 119.5 else f"{seconds // 60:.0f} min"
    return f"{seconds / 3600:.1f} h" if seconds < 35_000 else f"{seconds / 3600:.0f} h"


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


def battery_trend(snapshot: Snapshot, now: float, width: int) -> Content:
    """What the charge does, and when it will be empty or full."""
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
    does = "charging" if battery.charging else "discharging"
    end = trend.end_text(snapshot.charge, charging=battery.charging)
    both = f"{does}, {end}"
    return Content((both if len(both) <= width else end) if end else does)


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


def motor_word(snapshot: Snapshot, now: float, release_key: str, width: int) -> Content:
    """IDLE, MOVING, STOPPED, or a STOP that the robot has not confirmed."""
    motor = snapshot.motor
    if snapshot.stop_asked is not None:
        return Content.styled(stop_unconfirmed(now - snapshot.stop_asked, width), BAD)
    if motor.received is None:
        offered = MOTOR in snapshot.offered
        return Content.styled("? NO DATA" if offered else "not offered by any node", OLD)
    if motor.is_old(now):
        return Content.styled(f"? silent, {age(now - motor.received)}", OLD)
    if motor.stopped:
        release = f" [@click=app.command('release')]({release_key} releases)[/]"
        return Content.assemble(("✗ STOPPED", BAD), Content.from_markup(release))
    return Content("▶ MOVING" if motor.moving else "● IDLE")


def stop_unconfirmed(waited: float, width: int) -> str:
    """`STOP SENT, no answer for 2 s (not confirmed by the robot)`, or as much as has room."""
    if waited < 1:
        return "STOP SENT"
    texts = [
        f"STOP SENT, no answer for {waited:.0f} s (not confirmed by the robot)",
        f"STOP SENT, no answer for {waited:.0f} s",
        f"STOP SENT, silent {waited:.0f} s",
    ]
    return next((text for text in texts if len(text) <= width), texts[-1])


def seconds_text(seconds: float) -> str:
    """`1.5 s`."""
    return f"{max(seconds, 0.0):.1f} s"
