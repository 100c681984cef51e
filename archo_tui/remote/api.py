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
from types import TracebackType
from typing import Any

from archo_tui.remote import finder
from archo_tui.remote.api_errors import Misused, checked_timeout, convert_unreached, data_or_raise
from archo_tui.remote.api_request import Request
from archo_tui.remote.api_status import Alarm, Battery, Goal, Motion, Queue, Status, from_reply
from archo_tui.remote.goal_handle import CANCEL_TIMEOUT, GoalHandle
from archo_tui.remote.protocol import is_stop


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
        with convert_unreached(), contextlib.closing(finder.choose({"to": to})) as console:
            self._path, self._hello = console.path, console.hello
        self._lock = threading.Lock()
        self._requests: weakref.WeakSet[Request] = weakref.WeakSet()
        self._handles: list[GoalHandle] = []
        self._is_closed = False
        _robots.add(self)

    def __enter__(self) -> Robot:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
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
            requests = [*self._requests]
        for handle in running:
            handle._request.give_up()
        end = time.monotonic() + CANCEL_TIMEOUT
        for handle in running:
            handle._has_ended.wait(max(end - time.monotonic(), 0.0))
        for request in requests:
            request.shut_down()

    def _leave_to_parent(self) -> None:
        """Close a forked child's copies of the parent's connections, and end its goal handles.

        Else the console would not notice the end of the parent, and let its goals run on.
        """
        for request in self._requests:
            request.close()
        for handle in self._handles:
            handle._leave_to_parent()
        self._lock, self._requests, self._handles = threading.Lock(), weakref.WeakSet(), []

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
            raise Misused("misuse", f"go sends goals, and {kind!r} is none: use robot.stop()")
        request = self._request(checked_timeout(timeout), words=words, wait=True, feedback=True)
        try:
            request.send()
            handle = GoalHandle(request)
            with self._lock:
                self._handles = [handle for handle in self._handles if not handle.done()] + [handle]
            handle._wait_until_accepted()
        except BaseException:
            request.give_up()
            request.shut_down()
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
        hello = self._hello
        robot = {name: hello.get(name) for name in ("engine", "domain")}
        with convert_unreached():
            try:
                _stop({"to": hello["name"]})
            except finder.NoConsole:
                _stop({"to": hello["namespace"], **robot})

    def set(self, node: str, name: str, value: Any, timeout: float | None = None) -> None:
        """Set a parameter of a node, and return once the node has accepted the value.

        Args:
            node: The name of the node: `motor_controller`.
            name: The name of the parameter: `max_speed`.
            value: A bool, number, text, or list of these, as the parameter's type is.
            timeout: See `Robot`.

        Raises:
            Refused: The node refuses the value.
            Unconfirmed: The node does not answer: it may have taken the value.
            Misused: There is no such parameter, or the value is beyond its range.
        """
        self.do("set", node, name, _text(value), timeout=timeout)

    def get(self, node: str, name: str, timeout: float | None = None) -> Any:
        """Return the value of a parameter: a bool, number, text, or list of these.

        Of a list the first 100 items are returned, of a text some 500 characters; NaN and infinity
        are texts.

        Args:
            node: The name of the node: `motor_controller`.
            name: The name of the parameter: `max_speed`.
            timeout: See `Robot`.

        Raises:
            Misused: There is no such node or parameter.
        """
        return self.do("get", node, name, timeout=timeout)["value"]

    def wait(self, *what: str | float, timeout: float | None = None) -> None:
        """Wait until the robot is in a state; for a goal of your own use `GoalHandle.wait`.

        Args:
            *what: `idle`, `ready`, `stopped`, `arrived` (the goal that runs now, whoever sent it),
                or `battery` and a number of percent.
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
        request = self._request(checked_timeout(timeout), words=["events"], follow=True)
        request.send()
        replies = request.replies()
        first = next(replies)  # The state: from here on all events come.
        return _events(request, first, replies)

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
        words = ["echo", topic, *fields]
        request = self._request(checked_timeout(timeout), words=words, follow=True)
        request.send()
        return _messages(request)

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
        fields = {"words": [*map(_text, words)], "wait": wait}
        with self._request(checked_timeout(timeout), **fields) as request:
            request.send()
            return data_or_raise(request.result())

    def _request(self, timeout: float | None, **fields: Any) -> Request:
        request = Request(self._path, timeout, fields)
        with self._lock:
            self._requests.add(request)
            is_closed = self._is_closed
        if is_closed:
            request.give_up()
            request.close()
            raise Misused("misuse", "this robot was closed: connect() again")
        return request


_robots: weakref.WeakSet[Robot] = weakref.WeakSet()


def _leave_to_parent() -> None:
    for robot in _robots:
        robot._leave_to_parent()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)


def stop(to: str = "") -> None:
    """Send STOP to every console that could be meant. See `archo_tui.stop`."""
    with convert_unreached():
        _stop({"to": to})


def _stop(selection: Mapping[str, Any]) -> None:
    """Send STOP to every console that is meant; raise the first failure, or `finder.NoConsole`."""
    for ended in finder.stop(selection, _ignore):
        data_or_raise({"code": ended.code, "text": ended.text})


def _events(
    request: Request, first: dict[str, Any], replies: Iterator[dict[str, Any]]
) -> Iterator[dict[str, Any]]:
    """Yield the events of a request, and close it at the end or when its timeout is over."""
    reply = first
    with contextlib.closing(request):
        while "code" not in reply:
            if "event" in reply:
                yield reply["event"]
            reply = next(replies)
        if reply["code"] != "ran_out":
            data_or_raise(reply)


def _messages(request: Request) -> Iterator[dict[str, Any]]:
    """Yield the messages of a topic, and close the request at the end or after its timeout."""
    with contextlib.closing(request):
        for reply in request.replies():
            if "message" in reply:
                yield reply["message"]
        if reply["code"] != "ran_out":
            data_or_raise(reply)


def _ignore(_text: str) -> None:
    """Drop a notice of `finder.stop`: the error that follows has the same text."""


def _text(value: Any) -> str:
    """Return a value as it is typed: texts unchanged, anything else as JSON."""
    try:
        return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    except (TypeError, ValueError) as error:
        raise Misused("misuse", f"{value!r:.40}: {error}") from None
