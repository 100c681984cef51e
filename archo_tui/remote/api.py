"""The robot of a console, for Python programs: `archo_tui.connect()`. Standard library only.

Each call has a connection of its own, so no call waits for another, in whatever thread it is made;
and as with a shell that is killed, closing it calls off what it asked for.
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
from archo_tui.remote.api_errors import Misused, checked_timeout, data_of, unreached
from archo_tui.remote.api_request import Request
from archo_tui.remote.api_status import Alarm, Battery, Goal, Motion, Queue, Status, from_reply
from archo_tui.remote.goal_handle import CANCEL_TIMEOUT, GoalHandle
from archo_tui.remote.protocol import is_stop


class Robot:
    """The robot of one console; made by `archo_tui.connect`. Use it as a context manager.

    Every method may be called from any thread, also at the same time: none waits for another.
    An exception in a call, ctrl+c too, calls off what that call asked for; leaving the `with`
    block cancels the goals that still run. Only a STOP is never called off. A forked child can
    call everything here, too; the goals of its parent stay the parent's, and end with it.

    Each `timeout` is in seconds. None means: as long as the console answers. A console that is
    suspended, or gone, is `Unreached` also then.
    """

    def __init__(self, to: str = "") -> None:
        """Find the console. See `archo_tui.connect`."""
        with unreached(), contextlib.closing(finder.choose({"to": to})) as console:
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

        Returns once the goals have ended, at most 5 s later. Only `stop` can be called after it.
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
        """Let go, in a forked child, of what its parent has asked for.

        A connection that the child keeps would outlive the parent: the console would not see that
        the parent has gone, and its goals would run on.
        """
        for request in self._requests:
            request.close()
        for handle in self._handles:
            handle._leave_to_parent()
        self._lock, self._requests, self._handles = threading.Lock(), weakref.WeakSet(), []

    def status(self, timeout: float | None = None) -> Status:
        """Return the state of the robot.

        Args:
            timeout: Seconds; None: as long as the console answers.
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

        Behind a goal that runs it waits in the queue. It ends with this program, as its `wait`
        says; `robot.do("go", "12")` leaves a goal to the console instead.

        Args:
            *numbers: Where to, a shelf's number; several are driven one after the other.
            kind: A goal of the robot file, as it is typed: `go`, `pose`.
            timeout: Seconds from now in which the robot has to arrive, or it is cancelled and
                `wait` raises RanOut; None: it may take any time.
            **values: The fields of a goal that has several, by their names: `x=1.5, y=2`.

        Returns:
            The handle: `wait`, `cancel`, `feedback`, `done`.

        Raises:
            Refused: The robot or the console refused; nothing is driven.
            Misused: The kind or the values mean nothing; nothing was sent.
            Cancelled: A STOP came before the goal had left, or it is held in the queue.
            Unreached: The console has gone or does not answer.
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
        """Cancel the running goal of this console, whoever asked the console for it.

        Args:
            timeout: Seconds for the robot's answer; None: as long as the console answers.

        Raises:
            Refused: No goal runs, or the robot refuses.
        """
        self.do("cancel", timeout=timeout)

    def stop(self, *ignored: object, **also_ignored: object) -> None:
        """Send STOP: it overtakes whatever waits, is final, and stays until it is released.

        Where this console has gone, STOP goes to every other console of the same robot. It takes
        at most 15 s, is written at once, and is carried out also when nobody waits for it.

        Args:
            *ignored: Anything: a STOP is never refused for what is given with it.
            **also_ignored: Anything.

        Raises:
            Unreached: It is not confirmed: the robot may be moving. A suspended console
                carries it out when it wakes.
            Refused: The robot did not confirm it.
        """
        hello = self._hello
        robot = {name: hello.get(name) for name in ("engine", "domain")}
        with unreached():
            try:
                _stop({"to": hello["name"]})
            except finder.NoConsole:
                _stop({"to": hello["namespace"], **robot})

    def set(self, node: str, name: str, value: Any, timeout: float | None = None) -> None:
        """Set a parameter.

        Args:
            node: Its node: `motor_controller`.
            name: Its name: `max_speed`.
            value: A bool, number, text, or list of these, as its type is.
            timeout: Seconds; None: as long as the console answers.

        Raises:
            Refused: The node refuses the value, or does not answer.
            Misused: There is no such parameter, or the value is beyond its range.
        """
        self.do("set", node, name, _text(value), timeout=timeout)

    def get(self, node: str, name: str, timeout: float | None = None) -> Any:
        """Return the value of a parameter.

        Args:
            node: Its node: `motor_controller`.
            name: Its name: `max_speed`.
            timeout: Seconds; None: as long as the console answers.
        """
        return self.do("get", node, name, timeout=timeout)["value"]

    def wait(self, *what: str | float, timeout: float | None = None) -> None:
        """Wait for the robot; for a goal of your own use `GoalHandle.wait`.

        Args:
            *what: `idle`, `ready`, `stopped`, `arrived` (the goal that runs now, whoever sent it),
                or `battery` and a number of percent.
            timeout: Seconds; None: as long as the console answers. Nothing is cancelled after it.

        Raises:
            RanOut: It is not so after `timeout` seconds.
            Refused: It can no longer become so.
        """
        self.do("wait", *map(_text, what), timeout=timeout)

    def events(self, timeout: float | None = None) -> Iterator[dict[str, Any]]:
        """Return an iterator over what happens from this call on; other calls go on beside it.

        Args:
            timeout: Seconds after which it ends; None: never, as long as the console answers.

        Returns:
            An iterator, for one thread, of events as `archo-tui events --follow --json` prints
            them: `level`, `source`, `text`.
        """
        request = self._request(checked_timeout(timeout), words=["events"], follow=True)
        request.send()
        replies = request.replies()
        first = next(replies)  # The state: from here on all events come.
        return _events(request, first, replies)

    def messages(
        self, topic: str, *fields: str, timeout: float | None = None
    ) -> Iterator[dict[str, Any]]:
        """Return an iterator over the messages of a topic; other calls go on beside it.

        It yields at most five a second, and leaves out those between.

        Args:
            topic: Its name: `/battery_level`.
            *fields: The dotted paths of fields, `pose.position.x`; without any the whole message.
            timeout: Seconds after which it ends; None: never, as long as the console answers.

        Returns:
            An iterator, for one thread, of mappings: fields by name, or the chosen ones by path.
            Numbers that JSON lacks are the texts `nan`, `inf` and `-inf`.

        Raises:
            Misused: There is no such topic or field, or a message is too large. The iterator
                raises it.
        """
        words = ["echo", topic, *fields]
        if is_stop({"words": words}):
            raise Misused("misuse", "messages takes a topic: use robot.stop()")
        request = self._request(checked_timeout(timeout), words=words, follow=True)
        request.send()
        return _messages(request)

    def do(self, *words: str, wait: bool = False, timeout: float | None = None) -> Any:
        """Carry out any verb of the shell: `robot.do("log_level", "dashboard", "debug")`.

        Args:
            *words: The verb and its words. A verb that asks a person takes `--yes`.
            wait: True, of goals: return when they have ended; any exception cancels them.
            timeout: Seconds after which what was sent is cancelled; None: as long as the console
                answers.

        Returns:
            The data that the verb has with `--json`; None: it has none.

        Raises:
            NotDone: As its subclass that says why.
        """
        if is_stop({"words": [*words]}):
            return self.stop()
        fields = {"words": [*map(_text, words)], "wait": wait}
        with self._request(checked_timeout(timeout), **fields) as request:
            request.send()
            return data_of(request.result())

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
    with unreached():
        _stop({"to": to})


def _stop(selection: Mapping[str, Any]) -> None:
    """Send STOP to every console that is meant.

    Args:
        selection: `to`, `engine` and `domain`, as `protocol.is_meant` takes them.

    Raises:
        NotDone: A console did not confirm it.
        finder.NoConsole: None could be meant.
    """
    for ended in finder.stop(selection, _ignore):
        data_of({"code": ended.code, "text": ended.text})


def _events(
    request: Request, first: dict[str, Any], replies: Iterator[dict[str, Any]]
) -> Iterator[dict[str, Any]]:
    """Yield the events among the replies to a request, and close it at the end.

    Args:
        request: The request.
        first: Its first reply.
        replies: The replies that follow.
    """
    reply = first
    with contextlib.closing(request):
        while "code" not in reply:
            if "event" in reply:
                yield reply["event"]
            reply = next(replies)
        if reply["code"] != "ran_out":
            data_of(reply)


def _messages(request: Request) -> Iterator[dict[str, Any]]:
    """Yield the messages of a topic that is followed, and close the request at the end."""
    with contextlib.closing(request):
        for reply in request.replies():
            if "message" in reply:
                yield reply["message"]
        if reply["code"] != "ran_out":
            data_of(reply)


def _ignore(_text: str) -> None:
    """Drop a notice: the error or the end tells the same."""


def _text(value: Any) -> str:
    """Return a value as it is typed.

    Raises:
        Misused: JSON has no such value.
    """
    try:
        return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    except (TypeError, ValueError) as error:
        raise Misused("misuse", f"{value!r:.40}: {error}") from None
