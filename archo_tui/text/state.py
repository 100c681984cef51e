"""The texts of battery, motion and gauges, as glyph, word and tone. Pure functions.

A text is a row of spans; the screen decides how a tone looks. Glyph and word alone tell the state,
for terminals without colours.
"""

from __future__ import annotations

import math
import re
from itertools import groupby

from archo_tui.base.errors import in_one_line
from archo_tui.base.safe_text import harmless
from archo_tui.robot.state.readings import GaugeReading
from archo_tui.robot.state.snapshot import Latch, Snapshot, StopAnswer
from archo_tui.station.conditions import battery_health, is_battery_low, open_stop_texts

PLAIN, STRONG, OLD, WARN, BAD = "plain", "strong", "old", "warn", "bad"  # Tones.
ACTIVE, EDGE = "active", "edge"  # The filled and the empty part of a bar.
BARS = "▁▂▃▄▅▆▇█"  # Of a curve in one line, the lowest first.
Spans = tuple[tuple[str, str], ...]  # Pairs of text and tone.
STOPPED: Spans = (("✗ STOPPED", WARN),)  # The tone of the alarm STOPPED.
_LATE = 3.0  # Seconds: a reading of every second that is older counts as old.
STILL_MOVING = "✗ STILL MOVING"  # The state of a robot that reports a stop, and moves.
STILL_RUNNING = "✗ A GOAL STILL RUNS"  # That of one whose goal from before the STOP still runs.


def share(value: float, low: float, high: float) -> float:
    """Return where a value lies from low to high, as 0 to 1; also if high - low overflows."""
    span = high / 2 - low / 2
    return min(max((value / 2 - low / 2) / span, 0.0), 1.0) if span > 0 else 0.0


def elsewhere_text(snapshot: Snapshot) -> str:
    """Return the namespaces of other robots on the graph, and the option to use; "" for none."""
    others = snapshot.other_namespaces
    return f"robots seen: {', '.join(others)}; use --namespace {others[0]}" if others else ""


def with_short_types(text: str) -> str:
    """Return a text in which types have no package: `String` for `std_msgs/msg/String`."""
    return re.sub(r"\b[a-z]\w*/(?:msg|srv|action)/(?=\w)", "", text)


def fault_text(fault: str, width: int) -> str:
    """Return why a topic is not used; as short as `wrong type: String` if `width` is small."""
    short = with_short_types(fault)
    found = re.match(r"\S+ is (\w+):", short)
    texts = fault, short, f"wrong type: {found[1]}" if found else short
    return next((text for text in texts if len(text) <= width), texts[-1])


def no_data_text(snapshot: Snapshot) -> str:
    """Return that no data has come from the robot yet, and the likely cause; "" once some has.

    If its file names no topic, a node on the graph counts as data.
    """
    topics = snapshot.file.shown_topics
    heard = (snapshot.battery.received, snapshot.motion.received, snapshot.pose.received)
    is_heard = any(time is not None for time in (*heard, *(g.received for g in snapshot.gauges)))
    if is_heard or snapshot.diagnostics or (snapshot.nodes and not topics):
        return ""
    lacking = [topic for topic in topics if topic not in snapshot.offered]
    unpublished = f"no node publishes {', '.join(lacking)}" if lacking else ""
    why = elsewhere_text(snapshot) or unpublished
    return f"no data yet: {why}" if why else "no data yet"


def not_drawn(error: Exception) -> str:
    """Return the text in the place of what could not be drawn."""
    return harmless(f"✗ cannot be drawn: {in_one_line(error)}")


def marked_tone(tone: str) -> str:
    """Return the tone of a mark that is drawn on a bar of the given tone."""
    return f"on {tone}"


def fixed_width(value: float | None, form: str) -> str:
    """Return a number in a format such as `5.1f`, or `--` as wide as 0 would be if it is None."""
    text = format(0.0, form)
    return "--".rjust(len(text)) if value is None else format(value, form)


def thousands(value: int | None) -> str:
    """Return a number with grouped digits, such as `15 420`, or `--` for None."""
    return "--" if value is None else f"{value:,}".replace(",", " ")


def age_text(seconds: float) -> str:
    """Return a duration as `0.4 s`, `12 s`, `3 min`, `0.2 h`; a negative one as `0.0 s`."""
    if seconds < 9.95:
        return f"{max(seconds, 0.0):.1f} s"
    if seconds < 600:
        return f"{seconds:.0f} s" if seconds < 120 else f"{seconds // 60:.0f} min"
    return f"{seconds / 3600:.1f} h" if seconds < 35_000 else f"{seconds / 3600:.0f} h"


def age_of_slow(received: float | None, now: float) -> Spans:
    """Return the age of a reading whose topic is slow, as `  6 s ago`; empty within 3 s."""
    age = 0.0 if received is None else now - received
    if age <= _LATE:
        return ()
    # Tenths would cost a drawing each.
    return ((f"  {age_text(age) if age > 10 else f'{age:.0f} s'} ago", OLD),)


def seconds_text(seconds: float) -> str:
    """Return a duration in seconds with one decimal, such as `1.5 s`; `0.0 s` if it is negative."""
    return f"{max(seconds, 0.0):.1f} s"


def battery_word(snapshot: Snapshot) -> tuple[str, str, str]:
    """Return glyph, word and tone of the battery's most important state, such as LOW or GOOD."""
    battery = snapshot.battery
    if battery.received is None:
        return "?", "NO DATA", OLD
    if battery_health(snapshot) == "replace":
        return "✗", "REPLACE", BAD
    if battery.unreadable:
        return "?", f"UNREADABLE {battery.unreadable}", WARN
    if battery.percentage is not None and battery.percentage <= 0:
        return "✗", "EMPTY", BAD
    if battery.charging:
        return "↯", "CHARGING", STRONG
    if is_battery_low(snapshot):
        return "▲", "LOW", WARN
    if battery.health and not battery_health(snapshot):
        return "?", battery.health, WARN
    return "●", "GOOD", PLAIN


def battery_line(snapshot: Snapshot, now: float, width: int) -> Spans:
    """Return the battery as `▲ LOW       18.0 % 21.3 V`, each number in a span of its own."""
    glyph, word, tone = battery_word(snapshot)
    battery = snapshot.battery
    charge = f"{fixed_width(battery.percentage, '5.1f')} %"
    if battery.received is not None and battery.is_old(now):
        text = f"{glyph} {word:<8}"
        old = f" (old, {now - battery.received:.0f} s)"
        old = old if len(f"{text} {charge}{old}") <= width else " (old)"
        return (text, OLD), (f" {charge}", OLD), (old, OLD)
    if battery.unreadable:
        return ((f"{glyph} {word}", tone),)
    volts = f" {fixed_width(battery.voltage, '4.1f')} V"
    line = [(f"{glyph} {word:<8}", tone), (f" {charge}", PLAIN), (volts, PLAIN)]
    if late := age_of_slow(battery.received, now):
        fits = sum(len(text) for text, _ in (*line, *late)) <= width
        line[len(line) if fits else 2 :] = late  # Its age is worth more than V.
    return tuple(line)


def charge_bar(percentage: float | None, threshold: float | None, width: int, tone: str) -> Spans:
    """Return the charge, in %, as a bar with a mark where it counts as low."""
    filled = 0.0 if percentage is None else percentage / 100 * width
    whole, rest = int(filled), filled - int(filled)
    cells = ["█"] * whole
    if len(cells) < width:
        cells.append(" ▏▎▍▌▋▊▉"[int(rest * 8)] if int(rest * 8) else "░")
    cells += ["░"] * (width - len(cells))
    tones = [tone if cell != "░" else EDGE for cell in cells]
    if threshold is not None:
        mark = min(int(threshold / 100 * width), width - 1)
        tones[mark] = marked_tone(tone if cells[mark] == "█" else EDGE)
        cells[mark] = "╎"
    runs = groupby(zip(cells, tones, strict=True), lambda pair: pair[1])
    return tuple(("".join(cell for cell, _ in run), tone) for tone, run in runs)


def motion_line(snapshot: Snapshot, now: float, width: int | None = None) -> Spans:
    """Return count and speed, as far as the robot file names them: `15 420 ticks 0.80 m/s`.

    Beyond a width the count loses its unit, its blanks, and is left out; the speed stays whole.
    """
    motion, unit, speed = snapshot.motion, motion_unit(snapshot, "count"), speed_text(snapshot)
    counts = [""]
    if unit is not None:
        grouped = thousands(motion.count)
        counts = [f"{grouped:>9} {unit}".rstrip(), grouped, grouped.replace(" ", ""), ""]
    room = math.inf if width is None else width - len(speed) - 1
    parts = next(count for count in counts if len(count.strip()) <= room or not count), speed
    tone = OLD if motion.received is None or motion.is_old(now) else PLAIN
    shown = enumerate(filter(None, parts))
    return tuple((f"{' ' if number else ''}{part}", tone) for number, part in shown)


def speed_text(snapshot: Snapshot) -> str:
    """Return the speed as `0.80 m/s x 7.5`; "" if the robot file names none."""
    unit = motion_unit(snapshot, "speed")
    if unit is None:
        return ""
    speed = f"{fixed_width(snapshot.motion.speed, '4.2f')} {unit}".rstrip()
    return f"{speed} {time_factor_text(snapshot)}".rstrip()


def time_factor_text(snapshot: Snapshot) -> str:
    """Return how many simulated seconds pass in a real one, `x 7.5`; "" if that is 1 or unknown."""
    return "" if snapshot.time_factor is None else f"x {snapshot.time_factor:g}"


def motion_unit(snapshot: Snapshot, name: str) -> str | None:
    """Return the unit of "count" or "speed"; None if the robot file lacks it."""
    types = {} if snapshot.file.motion is None else snapshot.file.motion.types
    fields = [getattr(given, name) for given in types.values()]
    return next((field.unit for field in fields if field is not None), None)


def motion_word(snapshot: Snapshot, now: float, width: int) -> Spans:
    """Return the robot's state, such as IDLE, MOVING, STOPPED, or why it is not known.

    A STOP that is not confirmed goes before all else.
    """
    motion, described = snapshot.motion, snapshot.file.motion
    if snapshot.open_stop is not None:
        texts = open_stop_texts(snapshot, snapshot.open_stop, now)
        if snapshot.open_stop.answer not in (StopAnswer.AWAITED, StopAnswer.NONE):
            texts = (f"✗ STOP {snapshot.open_stop.answer.value}",)  # The banner says why.
        text = next((text for text in texts if len(text) <= width), texts[-1])
        return ((text[:width], BAD),)
    if snapshot.latch is Latch.UNCERTAIN:
        return (("✗ STOP NOT CERTAIN", BAD),)
    if snapshot.runs_on:
        return ((STILL_MOVING if snapshot.stop_not_obeyed else STILL_RUNNING, BAD),)
    if snapshot.stop_holds and not motion.moving and not motion.is_old(now):
        return STOPPED
    if described is None:
        return (("the robot file names no motion", OLD),)
    if motion.received is None:
        if described.topic in snapshot.faults:
            return ((fault_text(snapshot.faults[described.topic], width), WARN),)
        offered = described.topic in snapshot.offered
        return (("? NO DATA" if offered else f"no node publishes {described.topic}", OLD),)
    if motion.is_old(now):
        return ((f"? silent, {age_text(now - motion.received)}", OLD),)
    if snapshot.says_stopped:
        return ((STILL_MOVING, BAD),) if snapshot.stop_not_obeyed else STOPPED
    word = ("▶ MOVING" if motion.moving else "● IDLE", PLAIN)
    if motion.moving is None:
        word = ("? not reported", OLD)
    if snapshot.latch is Latch.HELD and motion.stopped is False and not motion.moving:
        text = "✗ STOP CONFIRMED, not reported by the robot"
        word = (text if len(text) <= width else "✗ STOP CONFIRMED", BAD)
    stop = snapshot.file.stop
    no_stop = "" if stop is None else snapshot.unavailable(stop.service)
    return (word, (f"   no STOP: {no_stop}", BAD)) if no_stop else (word,)


def motion_age(snapshot: Snapshot, now: float) -> Spans:
    """Return how long ago a slow robot has reported what `motion_word` says; empty if it has not.

    An open or doubtful STOP and silence have words that are no report.
    """
    motion, is_doubtful = snapshot.motion, snapshot.latch is Latch.UNCERTAIN
    is_other = snapshot.open_stop is not None or is_doubtful or snapshot.runs_on
    return () if is_other or motion.is_old(now) else age_of_slow(motion.received, now)


def gauge_line(reading: GaugeReading, now: float) -> Spans:
    """Return a gauge as `Temperature 41.2 °C`, the number in a span of its own."""
    name, unit = reading.gauge.title, reading.gauge.unit
    if reading.received is None:
        return (name, OLD), (f" -- {unit}".rstrip(), OLD)
    if reading.unreadable:
        return ((f"? {name} UNREADABLE {reading.unreadable}", WARN),)
    text = f" {reading.value:g} {unit}".rstrip()
    if reading.is_old(now):
        return (name, OLD), (f"{text} (old, {age_text(now - reading.received)})", OLD)
    if reading.warning:
        return (f"▲ {name}", WARN), (f"{text}, {reading.warning}", WARN)
    return (name, PLAIN), (text, PLAIN), *age_of_slow(reading.received, now)


def pose_line(snapshot: Snapshot, now: float) -> Spans:
    """Return where the robot is as `x 1.2  y 0.4  90°  map`; empty if no pose is named."""
    pose = snapshot.pose
    if snapshot.file.pose is None:
        return ()
    if pose.received is None:
        return (("pose", OLD), (" --", OLD))
    parts = [f"x {fixed_width(pose.x, '.1f')}", f"y {fixed_width(pose.y, '.1f')}"]
    if pose.yaw is not None:
        parts.append(f"{pose.yaw:.0f}°")
    text = "  ".join([*parts, *filter(None, [pose.frame])])
    if pose.is_old(now):
        return ((f"{text} (old, {age_text(now - pose.received)})", OLD),)
    return (text, PLAIN), *age_of_slow(pose.received, now)


def no_reading_reason(snapshot: Snapshot) -> str:
    """Return why no reading of the battery was received; call it only while that is so."""
    described = snapshot.file.battery
    if described is None:
        return "the robot file names no battery"
    return no_message_reason(snapshot, described.topic)


def no_message_reason(snapshot: Snapshot, topic: str) -> str:
    """Return why no message of a topic was received; call it only while that is so."""
    if topic in snapshot.faults:
        return snapshot.faults[topic]
    return f"waiting for {topic}" if topic in snapshot.offered else f"no node publishes {topic}"
