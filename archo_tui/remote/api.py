"""The robot of a console, for Python programs: `archo_tui.connect()`. Standard library only.

Each call has a connection of its own, so no call waits for another, in whatever thread it is made;
and as with a shell that is killed, closing it calls off what it asked for.
"""

from __future__ import annotations

import contextlib
import json
import os
import socket
import threading
import time
import weakref
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from types import TracebackType
from typing import Any, TypeVar

from archo_tui.errors import ArchoError
from archo_tui.remote import client, finder
from archo_tui.remote.protocol import GONE, LONGEST_WAIT, is_stop, is_wait


class NotDone(ArchoError):
    """The base of all errors here: a call did not do what it was asked for.

    Attributes:
        code: How it ended, a word of docs/protocol.md: `refused`, `misuse`, `aborted`.
    """

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code = code


class Refused(NotDone):
    """The robot or the console refused, or did not confirm; nothing was done."""


class Misused(NotDone):
    """The arguments mean nothing here; nothing was sent."""


class Aborted(NotDone):
    """The goal ended, and the robot has not arrived."""


class Cancelled(NotDone):
    """The goal was cancelled, by whomever, or is held in the queue."""


class RanOut(NotDone):
    """The time given as `timeout` is over."""


class Unreached(NotDone):
    """No console runs, several do, or it does not answer: the robot may still be moving."""


_ERRORS: dict[str, type[NotDone]] = {
    "misuse": Misused,
    "aborted": Aborted,
    "cancelled": Cancelled,
    "held": Cancelled,
    "ran_out": RanOut,
    "lost": Unreached,
    "unreached": Unreached,
}
_GOOD = ("done", "accepted", "arrived")
_SILENCE = 10.0  # s without a message after which the console is asked whether it still answers
_CONFIRMED = 5.0  # s in which the end of a goal that is called off is confirmed
_ANSWERED = 5.0  # s after `timeout`: a console calls off for 3 s, and says then that it is over
_PARENTS = "the goal is of the process that forked this one; the robot may still be moving"
_Kind = TypeVar("_Kind")


@dataclass(frozen=True)
class Battery:
    """The last reading of the battery.

    Attributes:
        percentage: 0 to 100; None: not received.
        voltage: In V; None: not received, or not reported by this robot.
        age: Seconds since the reading; None: never received.
    """

    percentage: float | None
    voltage: float | None
    charging: bool | None
    word: str
    age: float | None
    source: str


@dataclass(frozen=True)
class Motion:
    """The last report of the robot about its motion.

    Attributes:
        stopped: True while a STOP is latched; None: not certain, or not reported.
        speed: In m/s; None: not received.
        age: Seconds since the report; None: never received.
    """

    moving: bool | None
    stopped: bool | None
    speed: float | None
    word: str
    age: float | None
    source: str


@dataclass(frozen=True)
class Goal:
    """The state of a goal at one moment.

    Attributes:
        code: How it ended: `arrived`, `cancelled`, `aborted`; None while it runs.
        mine: True when this console sent it, whoever asked the console to.
        remaining: Metres left, as the robot reports them; None: not reported yet.
        length: Metres of the whole way; None: not known.
        age: Seconds since the robot last reported on it; None: never.
    """

    kind: str
    values: Mapping[str, Any]
    name: str
    phase: str
    code: str | None
    mine: bool
    remaining: float | None
    length: float | None
    message: str
    age: float | None
    source: str


@dataclass(frozen=True)
class Queue:
    """The goals that wait, and why they are held; an empty text: they are not."""

    waiting: list[str]
    held: str


@dataclass(frozen=True)
class Alarm:
    """An alarm; `since` is a Unix time in seconds."""

    name: str
    text: str
    priority: str
    state: str
    since: float


@dataclass(frozen=True)
class Status:
    """The state of the robot, as `archo-tui status --json` prints it.

    Attributes:
        stop: `open`: a STOP is not confirmed; `uncertain`: it may no longer hold; else empty.
        line: All of it in one line of text.
    """

    robot: str
    namespace: str
    watching: bool
    battery: Battery
    motion: Motion
    goal: Goal | None
    queue: Queue
    alarms: list[Alarm]
    stop: str
    line: str


class _Request:
    """A request on a connection of its own, which is closed at the end or by any exception."""

    def __init__(self, path: str, timeout: float | None, asked: Mapping[str, Any]) -> None:
        """Connect; `begin` sends the request.

        Args:
            path: The socket of the console.
            timeout: Seconds after which the console ends it; None: never.
            asked: The names and values of the request, as docs/protocol.md lists them.

        Raises:
            Unreached: The console has gone, or does not say hello.
        """
        self._path, self._timeout, self._asked = path, timeout, asked
        self._end: float | None = None  # monotonic time, in s
        with _unreached():
            self._console = finder.reach(path)

    def __enter__(self) -> _Request:
        return self

    def __exit__(self, kind: object, error: BaseException | None, at: object) -> None:
        if error is not None:
            self.give_up()
        self.close()

    def __del__(self) -> None:
        if hasattr(self, "_console"):  # an iterator over events that was never begun
            self.close()

    def begin(self) -> None:
        """Send the request. Raises Unreached."""
        if self._timeout is not None:
            self._end = time.monotonic() + self._timeout + _ANSWERED
        with _unreached():
            self._say({"id": 1, "timeout": self._timeout, **self._asked})

    def messages(self) -> Iterator[dict[str, Any]]:
        """Yield all that the console says, the result last.

        Raises:
            Unreached: The console has gone or no longer answers, or `timeout` passed without a
                result.
        """
        said: dict[str, Any] = {}
        while "code" not in said:
            left = LONGEST_WAIT if self._end is None else self._end - time.monotonic()
            try:
                said = next(self._console.remaining_replies(min(max(left, 0.0), _SILENCE)))
            except client.Silent as error:
                if left <= _SILENCE:
                    raise Unreached("unreached", str(error)) from None
                self._check_that_it_answers()
                continue
            except client.Unreached as error:
                raise Unreached("unreached", str(error)) from None
            yield said

    def result(self) -> dict[str, Any]:
        """Return the result. Raises what `messages` raises."""
        said: dict[str, Any] = {}
        for said in self.messages():  # noqa: B007  # the last one is wanted
            pass
        return said

    def give_up(self) -> None:
        """Call off what was asked for, without waiting until that is done."""
        with contextlib.suppress(client.Unreached):
            self._say({"give_up": True})

    def close(self) -> None:
        """Close the connection: the console calls off what is still underway."""
        self._console.close()

    def shut(self) -> None:
        """End the connection under a thread that reads it, which then closes it."""
        if self._console.socket is not None:
            with contextlib.suppress(OSError):  # it is closed already
                self._console.socket.shutdown(socket.SHUT_RDWR)

    def _say(self, said: dict[str, Any]) -> None:
        assert self._console.socket is not None
        if self._console.socket.fileno() >= 0:  # not closed
            self._console.send(said)

    def _check_that_it_answers(self) -> None:
        """Raise Unreached when the console takes no other connection either."""
        with _unreached():
            finder.reach(self._path, _SILENCE).close()


class GoalHandle:
    """A goal that the robot has accepted, or several that it drives one after the other.

    Every method may be called from any thread, also at the same time. `Robot.go` makes it.
    """

    def __init__(self, request: _Request) -> None:
        self._request = request
        self._is_accepted, self._has_ended = threading.Event(), threading.Event()
        self._result: dict[str, Any] = {"code": "lost", "text": GONE}
        self._state: Goal | None = None
        threading.Thread(target=self._read, name="goal", daemon=True).start()

    def wait(self, timeout: float | None = None) -> Goal:
        """Wait until the goal has ended.

        Any other exception here, ctrl+c too, cancels the goal.

        Args:
            timeout: Seconds to wait; None: until it has ended. The goal goes on behind it.

        Returns:
            The goal at its end, of several the last one.

        Raises:
            Aborted: It ended, and the robot has not arrived.
            Cancelled: It was cancelled, by whomever, or is held in the queue.
            RanOut: `timeout` seconds passed, and it still runs; or the time given to `go` is over.
            Unreached: The console has gone or no longer answers: the robot may still be moving.
        """
        try:
            has_ended = self._has_ended.wait(_seconds(timeout))
        except BaseException:
            self._request.give_up()
            raise
        if not has_ended:
            raise RanOut("ran_out", f"not within {timeout:g} s: the goal still runs")
        return _made(Goal, _data_of(self._result))

    def cancel(self, timeout: float = _CONFIRMED) -> None:
        """Cancel the goal, and those behind it in the same `go`; does nothing once it has ended.

        Args:
            timeout: Seconds to wait for the end.

        Raises:
            RanOut: The end was not confirmed in that time: the robot may still be moving.
            Unreached: The console has gone or no longer answers: the robot may still be moving.
        """
        self._request.give_up()
        if not self._has_ended.wait(_seconds(timeout)):
            raise RanOut("ran_out", "the cancel is not confirmed: the robot may still be moving")
        if _ERRORS.get(self._result["code"]) is Unreached:  # it ended for this program only
            _data_of(self._result)

    def feedback(self) -> Goal | None:
        """Return the newest state of the goal, without waiting; of several that which is driven.

        Returns:
            The state; its `remaining` is the way left, in metres. None: not reported yet.
        """
        return self._state

    def done(self) -> bool:
        """Return True once the goal has ended, however it did."""
        return self._has_ended.is_set()

    def _leave_to_parent(self) -> None:
        """End here, in a forked child: the thread that reads is not in it."""
        self._result = {"code": "lost", "text": _PARENTS}
        # new ones: whoever held those of the parent is not in the child either
        self._is_accepted, self._has_ended = threading.Event(), threading.Event()
        self._is_accepted.set()
        self._has_ended.set()

    def _wait_until_accepted(self) -> None:
        """Wait for the robot's answer. Raises what `Robot.go` raises."""
        self._is_accepted.wait()
        if self._has_ended.is_set():
            _data_of(self._result)

    def _read(self) -> None:
        """Read what the console says, on a thread of its own."""
        try:
            for said in self._request.messages():
                if "goal" in said:
                    self._state = _made(Goal, said["goal"])
                elif "code" in said:
                    self._result = said
                    if said.get("data"):
                        self._state = _made(Goal, said["data"])
                elif "said" in said:
                    self._is_accepted.set()
        except NotDone as error:
            self._result = {"code": error.code, "text": str(error)}
        finally:
            self._has_ended.set()
            self._is_accepted.set()
            self._request.close()


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
        with _unreached(), contextlib.closing(finder.choose({"to": to})) as console:
            self._path, self._hello = console.path, console.hello
        self._lock = threading.Lock()
        self._requests: weakref.WeakSet[_Request] = weakref.WeakSet()
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
        """Leave: goals of `go` that still run are cancelled, and calls in other threads end.

        Returns once the goals have ended, at most 5 s later. Only `stop` can be called after it.
        """
        with self._lock:
            self._is_closed = True
            running = [handle for handle in self._handles if not handle.done()]
            requests = [*self._requests]
        for handle in running:
            handle._request.give_up()
        end = time.monotonic() + _CONFIRMED
        for handle in running:
            handle._has_ended.wait(max(end - time.monotonic(), 0.0))
        for request in requests:
            request.shut()

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
        told = self.do("status", timeout=timeout)
        return _made(
            Status,
            {
                **told,
                "battery": _made(Battery, told["battery"]),
                "motion": _made(Motion, told["motion"]),
                "goal": _made(Goal, told["goal"]) if told["goal"] else None,
                "queue": _made(Queue, told["queue"]),
                "alarms": [_made(Alarm, alarm) for alarm in told["alarms"]],
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
        request = self._request(_seconds(timeout), words=words, wait=True, feedback=True)
        try:
            request.begin()
            handle = GoalHandle(request)
            with self._lock:
                self._handles = [one for one in self._handles if not one.done()] + [handle]
            handle._wait_until_accepted()
        except BaseException:
            request.give_up()
            request.shut()
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
        with _unreached():
            try:
                _stop({"to": hello["name"]})
            except finder.Nobody:
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
        request = self._request(_seconds(timeout), words=["events"], follow=True)
        request.begin()
        messages = request.messages()
        first = next(messages)  # the state: from here on all events come
        return _events(request, first, messages)

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
        asked = {"words": [*map(_text, words)], "wait": wait}
        with self._request(_seconds(timeout), **asked) as request:
            request.begin()
            return _data_of(request.result())

    def _request(self, timeout: float | None, **asked: Any) -> _Request:
        request = _Request(self._path, timeout, asked)
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
    with _unreached():
        _stop({"to": to})


def _stop(asked: Mapping[str, Any]) -> None:
    """Send STOP to every console that is meant.

    Args:
        asked: `to`, `engine` and `domain`, as `protocol.is_meant` takes them.

    Raises:
        NotDone: A console did not confirm it.
        finder.Nobody: None could be meant.
    """
    for ended in finder.stop(asked, _ignore):
        _data_of({"code": ended.code, "text": ended.text})


def _events(
    request: _Request, first: dict[str, Any], messages: Iterator[dict[str, Any]]
) -> Iterator[dict[str, Any]]:
    """Yield the events among the messages of a request, and close it at the end."""
    said = first
    with contextlib.closing(request):
        while "code" not in said:
            if "event" in said:
                yield said["event"]
            said = next(messages)
        if said["code"] != "ran_out":
            _data_of(said)


def _data_of(result: Mapping[str, Any]) -> Any:
    """Return the data of a result; raise the error of its code if that is none of success."""
    code = result["code"]
    if code not in _GOOD:
        raise _ERRORS.get(code, Refused)(code, result["text"])
    return result.get("data")


@contextlib.contextmanager
def _unreached() -> Iterator[None]:
    """Raise the connection's `Unreached` as the one of this module."""
    try:
        yield
    except client.Unreached as error:
        raise Unreached("unreached", str(error)) from None


def _seconds(timeout: float | None) -> float | None:
    """Return a timeout. Raises Misused when it is no time in seconds."""
    if timeout is not None and not is_wait(timeout):
        raise Misused("misuse", f"timeout: not a time in s: {str(timeout)[:40]}")
    return timeout


def _ignore(_text: str) -> None:
    """Leave a notice aside: the error or the end says it, too."""


def _made(kind: type[_Kind], told: Mapping[str, Any]) -> _Kind:
    """Make one from what a console says, which may be newer and say more."""
    return kind(**{field.name: told[field.name] for field in fields(kind)})  # type: ignore[arg-type]


def _text(value: Any) -> str:
    """Return a value as it is typed. Raises Misused when JSON has no such values."""
    try:
        return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    except (TypeError, ValueError) as error:
        raise Misused("misuse", f"{value!r:.40}: {error}") from None
