"""The robot of a console, for Python programs: `archo_tui.connect()`. Standard library only.

Each call has a connection of its own; when it closes, the console calls off what it requested.
"""

from __future__ import annotations

import contextlib
import json
import os
import threading
import time
import weakref
from collections.abc import Iterator, Mapping
from typing import Any

from archo_tui.client import find
from archo_tui.client.connection import Connection, close_all, reach
from archo_tui.client.errors import (
    ERRORS,
    Misused,
    NotDone,
    RanOut,
    Unconfirmed,
    Unreached,
    checked_timeout,
    data_or_raise,
)
from archo_tui.client.protocol import GONE, is_stop
from archo_tui.client.state import Alarm, Battery, Goal, Motion, Queue, Status, from_reply

CANCEL_TIMEOUT = 5.0  # s in which the end of a goal that is called off is confirmed
PARENTS_GOAL = "the goal is of the process that forked this one; the robot may still be moving"


class GoalHandle:
    """A goal that the robot has accepted or that waits in the console's queue; `Robot.go` makes it.

    Several goals of one `go` share a handle; the robot drives them one after the other. Every
    method may be called from any thread.
    """

    def __init__(self, console: Connection, replies: Iterator[dict[str, Any]]) -> None:
        self._console, self._replies = console, replies
        _handles.add(self)
        self._is_answered, self._has_ended = threading.Event(), threading.Event()
        self._is_accepted = False
        self._result: dict[str, Any] = {"code": "lost", "text": GONE}
        self._state: Goal | None = None
        threading.Thread(target=self._read_replies, name="goal", daemon=True).start()

    def wait(self, timeout: float | None = None) -> Goal:
        """Wait until the goal has ended, and return it if the robot has arrived.

        Of several goals the last one is returned. An exception that interrupts the wait, such as
        KeyboardInterrupt, cancels the goal.

        Args:
            timeout: Seconds to wait, after which the goal runs on; None: until it has ended.

        Raises:
            Aborted: The goal ended, and the robot has not arrived.
            Cancelled: The goal was cancelled by anybody, or is held in the queue.
            Refused: A goal that waited in the queue was refused when its turn came.
            Unconfirmed: The goal is lost, or the robot does not answer: it may still be moving.
            RanOut: `timeout` seconds passed, and the goal still runs; or the time given to `go` is
                over.
            Unreached: The console has gone or no longer answers: the robot may still be moving.
            Misused: `timeout` is not a valid time; the goal runs on.
        """
        seconds = checked_timeout(timeout)
        try:
            has_ended = self._has_ended.wait(seconds)
        except BaseException:
            self._console.give_up()
            raise
        if not has_ended:
            raise RanOut(f"not within {timeout:g} s: the goal still runs")
        return from_reply(Goal, data_or_raise(self._result))

    def cancel(self, timeout: float = CANCEL_TIMEOUT) -> None:
        """Cancel the goal and those behind it in the same `go`, and wait for the end.

        Does nothing once the goal has ended. However it ends, also by arriving, no error is raised.

        Args:
            timeout: Seconds to wait for the end.

        Raises:
            RanOut: The end was not confirmed in that time: the robot may still be moving.
            Unreached: The console has gone or no longer answers: the robot may still be moving.
            Misused: `timeout` is not a valid time; the goal is cancelled all the same.
        """
        self._console.give_up()
        if not self._has_ended.wait(checked_timeout(timeout)):
            raise RanOut("the cancel is not confirmed: the robot may still be moving")
        # It ended for this program only, or nobody knows whether it did.
        if ERRORS.get(self._result["code"]) in (Unreached, Unconfirmed):
            data_or_raise(self._result)

    def feedback(self) -> Goal | None:
        """Return the newest state of the goal, without waiting; None: not reported yet.

        Of several goals it is the one that is driven; after the end, the last one as it ended.
        """
        return self._state

    def done(self) -> bool:
        """Return True once the goal has ended in any way, or the console is unreachable."""
        return self._has_ended.is_set()

    def _wait_for_answer(self) -> None:
        """Wait until the goal is accepted or queued; raise why it is not."""
        self._is_answered.wait()
        if not self._is_accepted:
            data_or_raise(self._result)

    def _leave_to_parent(self) -> None:
        """End the handle in a forked child, which has no thread that reads replies."""
        self._result = {"code": "lost", "text": PARENTS_GOAL}
        # A new event: a thread of the parent, which the child lacks, may hold the old one's lock.
        self._has_ended = threading.Event()
        self._has_ended.set()

    def _read_replies(self) -> None:
        try:
            for reply in self._replies:
                if "code" not in reply:  # It is accepted or queued.
                    self._is_accepted = True
                    self._is_answered.set()
                if "goal" in reply:
                    self._state = from_reply(Goal, reply["goal"])
                elif "code" in reply:
                    self._result = reply
                    if reply.get("data"):
                        self._state = from_reply(Goal, reply["data"])
        except NotDone as error:
            self._result = {"code": error.code, "text": str(error)}
        finally:
            self._has_ended.set()
            self._is_answered.set()
            self._console.close()


class Robot:
    """The robot of one console; made by `archo_tui.connect`. Use it as a context manager.

    Every method may be called from any thread, also at the same time: none waits for another. An
    exception in a call, such as KeyboardInterrupt, calls off what that call requested; leaving the
    `with` block cancels the goals that still run. Only a STOP is never called off. A forked child
    can call everything here, too; goals that the parent has sent stay the parent's, and end with
    it.

    Each `timeout` is in seconds; None waits for as long as the console answers. Unless an iterator
    ends there, RanOut is raised once it is over. Every method raises Unreached if the console has
    gone or is suspended, and Misused if `timeout` is not a valid time.
    """

    def __init__(self, to: str = "") -> None:
        """Find the console, without keeping a connection. See `archo_tui.connect`."""
        with find.choose({"to": to}) as console:
            self._path, self._card = console.path, console.card
        self._lock = threading.RLock()  # A signal handler may call what it interrupts.
        self._connections: weakref.WeakSet[Connection] = weakref.WeakSet()
        self._handles: list[GoalHandle] = []
        self._is_closed = False
        _robots.add(self)

    def __enter__(self) -> Robot:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Cancel the goals of `go` that still run, and end calls in other threads.

        Returns when the goals have ended, after 5 s at most; a goal that has not ended by then
        raises no error. The ended calls, iterators too, raise Unreached. Later calls raise Misused,
        except `stop` and `close`.
        """
        with self._lock:
            self._is_closed = True
            running = [handle for handle in self._handles if not handle.done()]
            connections = [*self._connections]
        for handle in running:
            handle._console.give_up()
        end = time.monotonic() + CANCEL_TIMEOUT
        for handle in running:
            handle._has_ended.wait(max(end - time.monotonic(), 0.0))
        for connection in connections:
            connection.shut_down()

    def _leave_to_parent(self) -> None:
        """Give a forked child's copy its own lock, which a thread of the parent may hold."""
        self._lock, self._connections, self._handles = threading.RLock(), weakref.WeakSet(), []

    def status(self, timeout: float | None = None) -> Status:
        """Return the state of the robot, with its goal, queue and alarms, at this moment.

        Args:
            timeout: See `Robot`.
        """
        reply = self.do("status", timeout=timeout)
        return from_reply(
            Status,
            {
                **reply,
                "battery": from_reply(Battery, reply["battery"]),
                "motion": from_reply(Motion, reply["motion"]),
                "goal": from_reply(Goal, reply["goal"]) if reply["goal"] else None,
                "queue": from_reply(Queue, reply["queue"]),
                "alarms": [from_reply(Alarm, alarm) for alarm in reply["alarms"]],
            },
        )

    def go(
        self, *numbers: float, kind: str = "go", timeout: float | None = None, **values: Any
    ) -> GoalHandle:
        """Send a goal, and return once the robot has accepted it: `robot.go(12).wait()`.

        If another goal runs or is being sent, this goal waits in the console's queue, and `go`
        returns without the robot's answer. Of several goals only the first is waited for. The
        console cancels the goal when this program ends or leaves the `with` block; a goal of
        `robot.do("go", "12")` runs on.

        Args:
            *numbers: Where to, a shelf's number; several are driven one after the other.
            kind: A goal of the robot file, as it is typed: `go`, `pose`.
            timeout: Seconds from now in which the robot has to arrive, or it is cancelled and
                `wait` raises RanOut; None: it may take any time.
            **values: The fields of a goal that has several, by their names: `x=1.5, y=2`.

        Raises:
            Refused: The robot or the console refused; nothing is driven.
            Unconfirmed: The robot has not answered: it may drive.
            Misused: Nothing was sent: the kind or the values mean nothing, or the battery is low;
                then `do("go", "12", "--yes")` sends it.
            Cancelled: A STOP came before the goal had left, or the goal is held in the queue.
            RanOut: `timeout` seconds passed before the robot had answered.
        """
        words = [kind, *map(_text, numbers), *(f"{name}={_text(v)}" for name, v in values.items())]
        if is_stop({"words": words}):
            raise Misused(f"go sends goals, and {kind!r} is none: use robot.stop()")
        seconds, console = checked_timeout(timeout), self._connect()
        try:
            with self._lock:  # `close` knows each goal that was sent.
                self._require_open()
                replies = console.request(seconds, words=words, wait=True, feedback=True)
                handle = GoalHandle(console, replies)
                self._handles = [handle for handle in self._handles if not handle.done()] + [handle]
            handle._wait_for_answer()
        except BaseException:
            console.give_up()
            console.shut_down()
            raise
        return handle

    def cancel(self, timeout: float | None = None) -> None:
        """Cancel the running goal of this console, whichever program or person sent it.

        Returns when the robot has accepted the cancel; the goal may end later. Goals in the queue
        are held, not cancelled.

        Args:
            timeout: See `Robot`.

        Raises:
            Refused: No goal runs, or the robot refuses.
            Unconfirmed: The robot does not answer.
            Misused: The running goal is another client's: `do("cancel", "--yes")` cancels it.
        """
        self.do("cancel", timeout=timeout)

    def stop(self, *ignored: object, **also_ignored: object) -> None:
        """Send STOP, and return once the robot has confirmed it; it holds until it is released.

        STOP jumps every queue, and requests that were made before it and not sent yet are not sent.
        It takes at most 15 s; a console that received it carries it out even if nobody waits for
        the result. If this console has gone, STOP goes to every other console of the same robot.
        Arguments are ignored: none makes a STOP fail.

        Raises:
            Unreached: The STOP is not confirmed: the robot may be moving. A suspended console
                carries it out when it wakes.
            Unconfirmed, Refused: The robot did not confirm the STOP, or refused it.
        """
        card = self._card
        robot = {name: card.get(name) for name in ("engine", "domain")}
        try:
            _stop({"to": card["name"]})
        except find.NoConsole:
            _stop({"to": card["namespace"], **robot})

    def set(self, *node_name_value: Any, timeout: float | None = None) -> None:
        """Set a parameter of a node, and return once the node has accepted the value.

        Args:
            node_name_value: `"motor_controller", "max_speed", 0.5`; without the node if only one
                has such a parameter. The value is a bool, number, text, or list of these.
            timeout: See `Robot`.

        Raises:
            Refused: The node refuses the value.
            Unconfirmed: The node does not answer: it may have taken the value.
            Misused: There is no such parameter, or the value is beyond its range.
        """
        self.do("set", *map(_text, node_name_value), timeout=timeout)

    def get(self, *node_name: str, timeout: float | None = None) -> Any:
        """Return the value of a parameter: a bool, number, text, or list of these.

        Of a list the first 100 items are returned, of a text some 500 characters; NaN and infinity
        are texts.

        Args:
            node_name: `"motor_controller", "max_speed"`; without the node if only one has such a
                parameter.
            timeout: See `Robot`.

        Raises:
            Misused: There is no such node or parameter.
        """
        return self.do("get", *node_name, timeout=timeout)["value"]

    def wait(self, *what: str | float, timeout: float | None = None) -> None:
        """Wait until the robot is in a state; for a goal of your own use `GoalHandle.wait`.

        Args:
            *what: `idle`, `ready`, `stopped`, `arrived` (the goal that runs now, whoever sent it),
                `left` and the way of that goal at which the wait ends, in m or as the robot file
                has it, or `battery` and a number of percent.
            timeout: See `Robot`. Nothing is cancelled after it.

        Raises:
            Refused: The robot cannot reach that state, or no goal runs that could arrive.
            Unconfirmed: With `arrived`: the goal is lost: the robot may still be moving.
            Aborted: With `arrived`: the goal has ended without arriving.
            Cancelled: With `arrived`: the goal was cancelled.
            Misused: There is no such state, or the robot has no battery.
        """
        self.do("wait", *map(_text, what), timeout=timeout)

    def events(self, timeout: float | None = None) -> Iterator[dict[str, Any]]:
        """Return an iterator over the events from this call on, for one thread.

        An event is what `archo-tui events --follow --json` prints: `level`, `source`, `text`. The
        iterator raises Unreached once the console has gone.

        Args:
            timeout: Seconds after which the iterator ends; None: it goes on while the console
                answers.
        """
        replies = self._follow(timeout, "events")
        next(replies, None)  # The state: from here on all events come.
        return (reply["event"] for reply in replies if "event" in reply)

    def messages(
        self, topic: str, *fields: str, timeout: float | None = None
    ) -> Iterator[dict[str, Any]]:
        """Return an iterator over the messages of a topic, for one thread.

        It yields at most five messages a second, and leaves out those between. Numbers that JSON
        lacks are the texts `nan`, `inf` and `-inf`.

        Args:
            topic: The name of the topic: `/battery_level`.
            *fields: The dotted paths of fields, `pose.position.x`, which are the keys then; without
                any the whole message.
            timeout: Seconds after which the iterator ends; None: it goes on while the console
                answers.

        Raises:
            Misused: There is no such topic or field, or a message is too large: raised by the
                iterator.
        """
        replies = self._follow(timeout, "echo", topic, *fields)
        return (reply["message"] for reply in replies if "message" in reply)

    def do(self, *words: str, wait: bool = False, timeout: float | None = None) -> Any:
        """Carry out any verb of the shell: `robot.do("log_level", "dashboard", "debug")`.

        Words that mean STOP call `stop`, whatever else is given, and return None.

        Args:
            *words: The verb and its words. A verb that asks a person takes `--yes`.
            wait: True, of goals: return when they have ended; any exception cancels them. Misused
                is raised for a verb without goals.
            timeout: Seconds after which RanOut is raised, and goals that were sent are cancelled;
                None: as long as the console answers.

        Returns:
            The data that the verb has with `--json`; None: it has none.

        Raises:
            NotDone: The verb was not carried out; the subclass says why, as RanOut or Refused.
        """
        if is_stop({"words": [*words]}):
            return self.stop()
        typed, seconds = [*map(_text, words)], checked_timeout(timeout)
        with self._connect() as console:
            return data_or_raise(console.result(seconds, words=typed, wait=wait))

    def _connect(self) -> Connection:
        console = reach(self._path)
        with self._lock:
            self._connections.add(console)
        try:
            self._require_open()
        except Misused:
            console.close()
            raise
        return console

    def _require_open(self) -> None:
        if self._is_closed:
            raise Misused("this robot was closed: connect() again")

    def _follow(self, timeout: float | None, *words: str) -> Iterator[dict[str, Any]]:
        """Yield replies until the time is over, from now on also if nothing is read of them yet."""
        seconds, console = checked_timeout(timeout), self._connect()
        return _until_over(console, console.request(seconds, words=[*words], follow=True))


_robots: weakref.WeakSet[Robot] = weakref.WeakSet()
_handles: weakref.WeakSet[GoalHandle] = weakref.WeakSet()


def _leave_to_parent() -> None:
    close_all()
    for handle in list(_handles):
        handle._leave_to_parent()
    for robot in list(_robots):
        robot._leave_to_parent()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)


def stop(to: str = "") -> None:
    """Send STOP to every console that could be meant. See `archo_tui.stop`."""
    _stop({"to": to})


def _stop(selection: Mapping[str, Any]) -> None:
    """Send STOP to every console that is meant; raise the first failure, or `find.NoConsole`."""
    for ended in find.stop(selection, _ignore):
        data_or_raise({"code": ended.code, "text": ended.text})


def _until_over(console: Connection, replies: Iterator[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield replies until the time is over; raise any other result's error."""
    with contextlib.closing(console):
        for reply in replies:
            if "code" not in reply:
                yield reply
            elif reply["code"] != "ran_out":
                data_or_raise(reply)


def _ignore(_text: str) -> None:
    """Drop a notice of `find.stop`: the error that follows has the same text."""


def _text(value: Any) -> str:
    """Return a value as it is typed: texts unchanged, anything else as JSON."""
    try:
        return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    except (TypeError, ValueError) as error:
        raise Misused(f"{value!r:.40}: {error}") from None
