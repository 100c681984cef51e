"""The handling of what is received: readings, log lines, records of consoles, answers.

All of it runs on the ROS thread.
"""

from __future__ import annotations

from typing import Any

from rcl_interfaces.msg import Log
from std_msgs.msg import String

from archo_tui.robot import audit_records
from archo_tui.robot.audit_records import AuditRecord
from archo_tui.robot.consoles import author
from archo_tui.robot.events import ROUTINE
from archo_tui.robot.graph.secrets import is_secret
from archo_tui.robot.outcome import Code
from archo_tui.robot.parts import Parts
from archo_tui.robot.readings.subscriptions import News
from archo_tui.robot.requests.goals import verb_of
from archo_tui.robot.state import MASK, Event, Goal, level_word, logger_node


def on_reading(robot: Parts, topic: str, news: News) -> None:
    """Count a message with a reading, and have a snapshot sent if a value changed."""
    robot.graph.on_topic_message(topic, robot.clock.monotonic())
    if robot.file.motion is not None and topic == robot.file.motion.topic:
        _on_motion(robot, topic)
    robot.snapshots.is_stale = True
    if news is News.WORDS:
        robot.snapshots.send_soon()
    elif news is News.NUMBERS:
        robot.snapshots.send_later()


def _on_motion(robot: Parts, topic: str) -> None:
    robot.goals.on_robot_message()
    if topic in robot.graph.publishers:  # The readings of several robots come mixed.
        return
    stop, motion = robot.file.stop, robot.telemetry.motion
    # One of several robots tells nothing about the others.
    if stop is not None and stop.service not in robot.graph.duplicates:
        robot.stop_sender.on_motion(motion)
    robot.changes.on_motion(motion, robot.clock.monotonic())


def on_log(robot: Parts, message: Log) -> None:
    """Add a line on /rosout to the events, unless it is another robot's, or comes as a record."""
    node = logger_node(message.name)
    console, now = author(node), robot.clock.now()
    if console:
        # Every other console sends the same line in its audit record.
        if console in robot.graph.silent_consoles:
            robot.reporter.add(Event(now, "PEER", console, message.msg))
        return
    if not robot.graph.is_ours(node):
        return  # It is another robot's.
    if node not in robot.own_nodes():
        _compare_clocks(robot, node, message.stamp)
    for kind in robot.file.goals:
        servers = robot.graph.servers.get(kind.action, ())
        if kind.refusals and node in servers and message.msg.startswith(kind.refusals):
            robot.goals.on_refusal_log(message.msg.removeprefix(kind.refusals))
    robot.graph.on_log_line(node, robot.clock.monotonic())
    # The robot's clock may differ, and the events are in order: so not by the stamp.
    level = level_word(message.level)
    event = robot.reporter.add_log_line(Event(now, level, message.name, message.msg))
    if level in ROUTINE or event.count > 1:
        robot.snapshots.send_later()
    else:
        robot.snapshots.send_soon()


def on_stamp(robot: Parts, topic: str, stamp: Any) -> None:
    """Compare the stamp in a header of a topic (full name) with this computer's clock."""
    # A node of this process shares its clock, and simulated time is no time of day.
    if not (robot.own_nodes() or robot.graph.has_clock):
        _compare_clocks(robot, topic, stamp)


def _compare_clocks(robot: Parts, source: str, stamp: Any) -> None:
    if robot.clock_offsets.add(source, stamp, robot.clock.now()):
        robot.snapshots.send_soon()


def on_audit_record(robot: Parts, message: String) -> None:
    """Add the record of what another console did to the events.

    Any report of a STOP voids what was requested here before and has not left yet.
    """
    published = audit_records.parse(message.data)
    if published is None or published.console not in robot.graph.consoles:
        return
    console, record, text = published
    robot.changes.on_audit_record(record, robot.clock.monotonic())
    robot.stops.sent_elsewhere += record.verb == "stop"
    robot.stops.superseded |= record.verb != "stop"
    if record.code is Code.DONE and record.verb == "stop":
        robot.stop_sender.on_stopped_elsewhere(console)
    elif record.code is Code.DONE and record.verb == "release":
        robot.stop_sender.on_released_elsewhere(console)
    robot.reporter.add(Event(robot.clock.now(), "PEER", console, text, audit_record=record))


def on_answered(robot: Parts, turn: int) -> None:
    """Send STOP again if the robot may have obeyed an answered request, by its turn, after it."""
    if robot.stop_sender.stop.must_follow(turn):
        robot.thread.submit(robot.stop_sender.send_after_late_answer)


def on_goal_change(robot: Parts, is_new_phase: bool) -> None:
    """Begin to check the goals, and show the change: at once if a goal has a new phase."""
    robot.stop_sender.begin_ticking()
    if robot.goal_timer.is_canceled():
        robot.goal_timer.reset()
    if is_new_phase:
        robot.snapshots.send()
    else:  # After feedback, so that the motion which is reported beside it is shown with it.
        robot.snapshots.send_soon()


def on_goal_end(robot: Parts, goal: Goal, text: str) -> None:
    """Add an event with an audit record about how a goal ended."""
    assert goal.code is not None  # It has ended.
    record = AuditRecord(*verb_of(robot, goal.kind, goal.fields), goal.code)
    event = Event(robot.clock.now(), "GOAL", goal.kind.action, text, audit_record=record)
    robot.reporter.add(event)


def on_new_value(robot: Parts, node: str, old: object, new: object) -> None:
    """Measure the periods of topics and feedback again, because a parameter has changed."""
    robot.telemetry.forget_periods(node, old, new)
    servers = robot.graph.servers
    robot.goals.forget_periods(old, new, lambda kind: node in servers.get(kind.action, ()))


def on_parameter_event(robot: Parts, node: str, name: str, old: Any, new: Any) -> None:
    """Record a change of a parameter, which nobody may report."""
    if is_secret(name):
        old = new = MASK
    robot.changes.on_parameter(node, name, old, new, robot.clock.monotonic())
