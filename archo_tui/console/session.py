"""The sessions of the console's clients: words in, outcomes out, questions between.

Clients are the programs on the socket, the operator of `--plain`, and a shell that attaches to the
robot without a console. All of it works on the console's loop, but for the handler's first methods.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any, NoReturn, Protocol

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.base.errors import ArchoError, in_one_line
from archo_tui.client.protocol import GONE, RESTARTS, is_stop, timeout_of, words_of
from archo_tui.console.assistants import Assistants
from archo_tui.robot.clients import ASSISTANT, YOU, Requester, on_behalf_of
from archo_tui.robot.messages.text import as_json as message_as_json
from archo_tui.robot.outcome import NOT_TAKEN_BACK, Code, Outcome, Report, answer_of, data_of
from archo_tui.robot.stop.gate import NOT_SENT, RateLimit, Void
from archo_tui.station.goal_driver import CALLED_OFF
from archo_tui.station.station import Station
from archo_tui.verbs import as_json, verbs
from archo_tui.verbs.goals import SendGoal
from archo_tui.verbs.services import Call, choose_verb
from archo_tui.verbs.topics import Echo
from archo_tui.verbs.verb import (
    TIMEOUT,
    YES,
    Question,
    Verb,
    candidates,
    named,
    parse,
    prepare_when_found,
    run_when_ready,
)
from archo_tui.verbs.waits import POLL_PERIOD, SENT, Wait, outcome_if_over

_MAX_STOPS = 1000  # STOPs that are answered: of a flood the last ones.
_REQUEST_INTERVAL = 0.02  # Seconds between two requests of one client.
_ANSWER_TIMEOUT = 60.0  # Seconds for a person at a shell to answer a question.
_CALL_OFF_TIMEOUT = 3.0  # Seconds for the end of work that was called off.
_BEAT_PERIOD = 0.2  # Seconds between two beats, which a client answers while what it began lasts.
_MAX_MISSED_BEATS = 5
_FOLLOW_PERIOD = 0.2  # Seconds between two polls: five a second, as on the screen.
_SUSPENDED = "ended: this program gave no sign for 1 s"


class Client(Protocol):
    """A client of the console; its methods may be called on any thread."""

    @property
    def pid(self) -> int:
        """The client's process; 0 if it is not known."""

    @property
    def requester(self) -> Requester | None:
        """The one on whose behalf the client acts; None: a program, which acts for itself."""

    @property
    def ask(self) -> Callable[[Question], Awaitable[None]] | None:
        """The way to ask the client, as in `run_when_ready`; None: by a reply, which it answers."""

    def reply(self, reply: dict[str, Any]) -> None:
        """Send a reply to the client, without waiting."""

    def on_request_ended(self) -> None:
        """Record that the client's request has ended, and have its next one carried out."""

    @property
    def is_behind(self) -> bool:
        """True while the client has not read all replies."""


class RequestHandler:
    """The handler of the requests of all clients."""

    def __init__(self, station: Station) -> None:
        self.station, self._robot = station, station.robot
        self.verbs: Mapping[str, Verb] = verbs(self._robot.file, self._robot.snapshot.forms)
        self.assistants = Assistants(station, self.verbs)
        self._sessions: dict[Client, Session] = {}
        # Clients whose STOP has not left yet, each with its request's id and whether it is an
        # assistant; and whether a task will send one for all of them.
        self._stops: deque[tuple[Client, Any, bool]] = deque(maxlen=_MAX_STOPS)
        self._stop_is_due = False
        self._rate_limit = RateLimit()

    # Called on any thread.

    def serve(self, client: Client, request: dict[str, Any], stops: int) -> None:
        """Begin to carry out a request; a STOP goes before all others.

        STOPs that wait at the same time are sent to the robot as one. A STOP read after the first
        `stops` ones, before the robot gets the request, makes the request void.
        """
        if is_stop(request):
            is_assistant = request.get("assistant") is True
            self._stops.append((client, request.get("id"), is_assistant))
            if not self._stop_is_due:  # One task for all: a flood would be as many tasks.
                self._stop_is_due = True
                self.station.post(self._stop)
        else:
            self.station.post(partial(self._serve, client, request, stops))

    def on_answer(self, client: Client, answer: dict[str, Any]) -> None:
        """Pass on the answer to a question, or call the client's request off at a `give_up`."""
        self.station.post(partial(self._on_answer, client, answer))

    def on_client_left(self, client: Client) -> None:
        """Call off the work that a client waits for.

        Goals that it did not wait for run on; those of an assistant do not.
        """
        self.station.post(partial(self._end_session, client))

    # Called on the console's loop.

    async def _stop(self) -> None:
        """Send one STOP for all that wait, within the rate limit, and reply to each client.

        An earlier STOP may still be unanswered. Open questions are closed.
        """
        clock = self.station.clock
        now: list[tuple[Client, Any, bool]] = []
        try:
            due = clock.monotonic() + self._rate_limit.delay(clock.monotonic())
            while clock.monotonic() < due and not self._robot.stops.superseded:
                await clock.sleep(POLL_PERIOD)
            self._stop_is_due = False
            now = [self._stops.popleft() for _ in range(len(self._stops))]
            if not now:  # Another task has sent one for them.
                return
            self._rate_limit.record(clock.monotonic())
            self.station.close_questions()
            client, _, is_assistant = now[0]
            with on_behalf_of(self._requester(client, is_assistant)):
                outcome = await self._send_stop()
        except asyncio.CancelledError:  # The screen ends: the next one sends it and answers.
            self._stops.extendleft(reversed(now))
            self._stop_is_due = True
            self.station.post(self._stop)
            raise
        for client, number, _ in now:
            client.reply(_result(number, outcome))

    def _requester(self, client: Client, is_assistant: bool) -> Requester:
        session = self._sessions.get(client)
        return requester_of(client, is_assistant) if session is None else session.requester

    async def _send_stop(self) -> Outcome:
        try:
            return await self.verbs["stop"].run(self.station, {})
        except Exception as error:  # Whatever failed, the client gets a reply.
            return Outcome(Code.REFUSED, in_one_line(error))

    def _session_of(self, client: Client) -> Session:
        if client not in self._sessions:
            self._sessions[client] = Session(self, client)
            self.publish_clients()
        return self._sessions[client]

    def publish_clients(self) -> None:
        sources = (session.requester.source for session in self._sessions.values())
        self.station.clients = tuple(sources)
        self.station.refresh()

    async def _end_session(self, client: Client) -> None:
        session = self._sessions.pop(client, None)
        if session is None:  # It requested nothing.
            return
        session.has_gone = True
        self.publish_clients()
        await session.call_off()

    async def _on_answer(self, client: Client, answer: dict[str, Any]) -> None:
        """Handle an answer to a question, a sign of life (`beat`), or the end of a request."""
        session = self._session_of(client)
        if "beat" in answer:
            session.missed_beats = 0
        elif not answer.get("give_up"):
            session.answer(answer.get("answer") is True)
        elif not await session.give_up():
            client.reply(_result(None, Outcome(Code.DONE, "it had ended")))

    async def _serve(self, client: Client, request: dict[str, Any], stops: int) -> None:
        client.reply(await self._session_of(client).carry_out(request, stops))
        client.on_request_ended()


class Session:
    """The requests of one client, one after the other: its goals, and its name in events."""

    def __init__(self, handler: RequestHandler, client: Client) -> None:
        self._handler, self._station, self._client = handler, handler.station, client
        # Of its last goals, also after its request ended.
        self._sent: list[asyncio.Future[Outcome]] = []
        self._answer: asyncio.Future[bool] | None = None  # None while nothing is asked.
        self._task: asyncio.Task[Any] | None = None  # None between requests.
        self._next_at = 0.0  # Monotonic s.
        self._late_cancels: set[asyncio.Future[None]] = set()  # Of work that ran out of time.
        self._is_assistant = self.has_gone = False
        self._start({})

    def _start(self, request: Mapping[str, Any]) -> None:
        """Set the attributes for the next request; an assistant keeps its requester for all."""
        words = request.get("words")
        if not self._is_assistant:
            self._is_assistant = request.get("assistant") is True
            self.requester = requester_of(self._client, self._is_assistant)
            if self._is_assistant:
                self._handler.publish_clients()
        # Set before the goals are sent: the client may have left by the time they are.
        self._is_waiting = request.get("wait") is True
        self.requester.waits = self._is_assistant or self._is_waiting
        word = words[0] if isinstance(words, list) and words else None
        self._verb = self._handler.verbs.get(word) if isinstance(word, str) else None
        # So cancelling the task calls it off.
        is_slow = self._verb is not None and self._verb.is_slow
        self._is_read_only = is_slow or bool(request.get("follow"))
        self._tells: dict[str, bool] = {}  # Of the result, once the verb is known.
        self.missed_beats = 0  # Since the client's last sign.
        self._is_called_off = False  # True once the task was cancelled to call its request off.

    @property
    def _calls_service(self) -> bool:
        """True for a request that nothing takes back once a service has it."""
        return isinstance(self._verb, Call)

    def answer(self, is_yes: bool) -> None:
        """Answer the open question; without one do nothing."""
        if self._answer is not None and not self._answer.done():
            self._answer.set_result(is_yes)

    async def give_up(self) -> bool:
        """Call the request off, and return True if there is one."""
        if self._task is None:
            return False
        if not (self._is_read_only or self.requester.ends or self._is_assistant):
            self.requester.has_left = True  # Nothing was sent; nothing will be.
        await self.call_off()
        if self._calls_service and self._task is not None:
            self._cancel_task()
        return True

    async def call_off(self) -> None:
        """Call off what the client waits for: deny its open question, and end the wait.

        Goals end if the client waits for them, or is an assistant that has left.
        """
        self.answer(False)
        ends_with_it = self._is_assistant and self.has_gone
        if self._task is not None and self._is_read_only:
            self._cancel_task()
        elif self._is_waiting:
            ends_with_it = True
        if ends_with_it:
            self.requester.has_left = True
            await self._station.goals.call_off(self.requester)

    def _cancel_task(self) -> None:
        assert self._task is not None
        self._is_called_off = True
        self._task.cancel()

    async def carry_out(self, request: dict[str, Any], stops: int) -> dict[str, Any]:
        """Carry out a request that was read after `stops` STOPs, and return its result."""
        station, clock = self._station, self._station.clock
        self._start(request)
        self._task = asyncio.current_task()
        try:
            if clock.monotonic() < self._next_at:
                await clock.sleep(self._next_at - clock.monotonic())
            with station.robot.stops.typed_at(stops), on_behalf_of(self.requester):
                outcome = await self._carry_out_in_time(request)
        except Void:
            outcome = Outcome(Code.CANCELLED, NOT_SENT)
        except _Declined as error:
            outcome = Outcome(Code.CANCELLED, str(error))
        except (ArchoError, ValueError) as error:
            outcome = Outcome(Code.MISUSE, str(error))
        except Exception as error:  # Whatever failed, the console goes on.
            outcome = Outcome(Code.REFUSED, in_one_line(error))
            station.robot.note("ERROR", "console", f"{self.requester.source}: {outcome.text}")
        except asyncio.CancelledError:
            if self.missed_beats >= _MAX_MISSED_BEATS:
                outcome = Outcome(Code.CANCELLED, _SUSPENDED)
            elif self._is_called_off:
                text = NOT_TAKEN_BACK if self._calls_service else CALLED_OFF
                outcome = Outcome(Code.CANCELLED, text)
            else:  # The screen ends or restarts, and the console keeps the goal.
                outcome = Outcome(Code.LOST, RESTARTS if station.is_restarting else GONE)
        finally:
            if self.requester.waits and not self._is_assistant:
                station.goals.take_out(self.requester)
            self._task, self._is_waiting = None, False
            self._next_at = clock.monotonic() + _REQUEST_INTERVAL
        return _result(request.get("id"), outcome, **self._tells)

    async def _carry_out_in_time(self, request: dict[str, Any]) -> Outcome:
        """Carry out a request within its `timeout`."""
        words, timeout = request.get("words"), timeout_of(request)
        waits = isinstance(words, list) and words[:1] == [Wait.id]  # Keeps the timeout itself.
        if timeout is None or waits or self._is_assistant:
            return await self._carry_out(request)
        work, clock = asyncio.ensure_future(self._carry_out(request)), self._station.clock
        over = f"not within {timeout:g} s"
        try:
            if timeout == 0 and self._verb is not None and self._verb.has_goals:
                return await self._call_off_late(work, over)  # Before its first step.
            with suppress(TimeoutError):
                return await clock.wait_for(asyncio.shield(work), timeout)
            if self._is_read_only:
                over = f"{timeout:g} s are over"
            elif self._calls_service:
                over += ": the robot may still do it"
            else:
                return await self._call_off_late(work, over)
            return Outcome(Code.RAN_OUT, over)
        finally:
            work.cancel()

    async def _call_off_late(self, work: asyncio.Future[Outcome], over: str) -> Outcome:
        """Call off work whose time is over; its outcome is returned if it is a success after all.

        Returns within 3 s: an unanswered cancel goes on alone.
        """
        self._is_waiting = self.requester.has_left = True
        cancel = asyncio.ensure_future(self.call_off())
        self._late_cancels.add(cancel)  # The loop holds tasks weakly.
        cancel.add_done_callback(self._late_cancels.discard)
        try:
            outcome = await self._station.clock.wait_for(asyncio.shield(work), _CALL_OFF_TIMEOUT)
        except TimeoutError:
            return Outcome(Code.RAN_OUT, f"{over}; what was sent may still be done")
        except _Declined:
            return Outcome(Code.RAN_OUT, f"{over}: nobody has answered")
        if outcome.code in (Code.DONE, Code.ARRIVED):  # At the last moment.
            return outcome
        self._tells = {}
        return Outcome(Code.RAN_OUT, f"{over}: {outcome.text}")

    async def _carry_out(self, request: dict[str, Any]) -> Outcome:
        """Carry out a request without a time limit; following events or a topic never returns."""
        number, station, verbs = request.get("id"), self._station, self._handler.verbs
        if self._is_assistant:
            return await self._handler.assistants.carry_out(self.requester, request)
        if "complete" in request:
            words = words_of({"words": request["complete"]})
            return Report.of("", candidates(verbs, station, words))
        word, *rest = words_of(request)
        if request.get("follow"):
            await self._follow(number, word, rest, as_text=request.get("as_text") is True)
        if "--help" in rest:
            verb = named(verbs, word)
            self._tells = {"tells": True}
            text = verb.help_line if self.requester is YOU else verb.help_text
            return Outcome(Code.DONE, text)
        verb, rest = choose_verb(verbs, station, word, rest)
        self._verb = verb
        if request.get("wait") is True and not verb.has_goals:
            raise ValueError(f"{word} has no --wait: it sends no goals")
        values, yes = parse(verb, rest)
        if isinstance(verb, (Call, Wait)):
            values = {**values, TIMEOUT: timeout_of(request), SENT: self._sent}
        by_reply = partial(self._ask, number, request.get("person") is True)
        ask = None if yes else self._client.ask or by_reply
        requester = self.requester
        beats = verb.lasts and requester is not YOU  # A program may be suspended.
        watch = asyncio.ensure_future(self._end_without_beats(number)) if beats else None
        try:
            outcome = await run_when_ready(station, verb, values, ask)
        finally:
            if watch is not None:
                watch.cancel()
        station.refresh()
        if requester is not YOU and requester.ends:
            self._sent = requester.ends
        if self._is_waiting and outcome.ok and requester.ends:
            self._client.reply({"id": number, "said": outcome.text})
            outcome = await self._wait_for_ends(number, request.get("feedback") is True)
            if station.is_restarting and outcome.code != Code.ARRIVED:
                outcome = outcome._replace(text=f"{outcome.text}: the console restarts")
        tells = verb.tells_with(values) if requester is YOU else verb.tells
        data, answer = data_of(outcome), answer_of(outcome)
        if answer is not None and word == "call" and requester is not YOU:
            data = await in_daemon(message_as_json, answer)  # A map has a million values.
        if self._is_waiting and requester.goal is not None:
            data = as_json.goal(requester.goal, station.clock.monotonic())
            if isinstance(verb, SendGoal) and requester.goal.result is not None:
                data["result"] = await in_daemon(message_as_json, requester.goal.result)
                tells = True
        self._tells = {"tells": tells}
        return Report.of(outcome.text, data, outcome.code)

    async def _end_without_beats(self, number: Any) -> None:
        """Call the request off once the client has left five beats unanswered: it is suspended.

        A program that waits for a person's answer reads nothing meanwhile, and is not judged.
        """
        while self.missed_beats < _MAX_MISSED_BEATS:
            if self._answer is None:
                self._client.reply({"id": number, "beat": True})
            await self._station.clock.sleep(_BEAT_PERIOD)
            self.missed_beats += self._answer is None
        self._cancel_task()

    async def _follow(self, number: Any, word: str, words: list[str], *, as_text: bool) -> None:
        """Send the client events, or messages of a topic, until the task is cancelled."""
        station, client = self._station, self._client
        if word == "echo":
            verb = self._handler.verbs["echo"]
            assert isinstance(verb, Echo)
            values, _ = parse(verb, words)
            prepared = await prepare_when_found(station, verb, values)
            if isinstance(prepared, Outcome):
                raise ArchoError(prepared.text)
            await verb.follow(
                station,
                prepared,
                partial(self._reply, number),
                for_program=not as_text,
                has_room=lambda: not client.is_behind,
            )
        if (word, *words) != ("events",):
            raise ValueError("only events can be followed, without further words")
        await _follow_events(station, partial(self._reply, number))

    def _reply(self, number: Any, reply: dict[str, Any]) -> None:
        self._client.reply({"id": number, **reply})

    async def _wait_for_ends(self, number: Any, feedback: bool) -> Outcome:
        """Wait for the ends of all goals, and return their combined outcome.

        A held goal that is continued gets a new future in `ends`, which is waited for, too.
        """
        requester, following = self.requester, None
        if feedback:
            work = _follow_goal(self._station, requester, partial(self._reply, number))
            following = asyncio.ensure_future(work)
        try:
            while (outcome := outcome_if_over(requester.ends)) is None:
                waited = [end for end in requester.ends if not end.done()]
                await asyncio.wait(waited[:1])  # Cancels no end when this is cancelled.
            return outcome
        finally:
            if following is not None:
                following.cancel()

    async def _ask(self, number: Any, person: bool, question: Question) -> None:
        """Ask the person at the shell: ArchoError if nobody is there, _Declined without a yes."""
        text = " ".join(question.text.split())
        if not person:
            raise ArchoError(f"{text} (add {YES} to do it)")
        self._answer = asyncio.get_running_loop().create_future()
        self._client.reply({"id": number, "ask": text, "safe": question.safe, "go": question.go})
        try:
            answer = await self._station.clock.wait_for(self._answer, _ANSWER_TIMEOUT)
        except TimeoutError:
            answer = False
        finally:
            self._answer = None
        if not answer:
            raise _Declined(question.safe.lower())


class _Declined(ArchoError):
    """The error for a question that was not answered with yes."""


def requester_of(client: Client, is_assistant: bool = False) -> Requester:
    """Return a new requester for a client, unless it acts on behalf of one."""
    number = str(client.pid) if client.pid else "unknown"
    if is_assistant:
        return Requester("AI", f"{ASSISTANT} {number}")
    return client.requester or Requester("SHELL", f"pid {number}")


def _result(number: Any, outcome: Outcome, **more: bool) -> dict[str, Any]:
    result = {"id": number, "code": outcome.code.value, "text": outcome.text, **more}
    data = data_of(outcome)
    return result if data is None else {**result, "data": data}


async def _follow_events(station: Station, send: Callable[[dict[str, Any]], None]) -> NoReturn:
    """Send each event from now on, and the state when its line changes, until cancelled.

    An event that repeats is sent again.
    """
    seen = {event.number: event.count for event in station.robot.snapshot.events}
    line = ""
    while True:
        events = station.robot.snapshot.events
        for new in events:
            if seen.get(new.number) != new.count:
                send({"event": as_json.event(new)})
        seen = {event.number: event.count for event in events}
        current = as_json.state(station)
        if current["line"] != line:
            line = current["line"]
            send({"state": current})
        await station.clock.sleep(_FOLLOW_PERIOD)


async def _follow_goal(
    station: Station, requester: Requester, send: Callable[[dict[str, Any]], None]
) -> NoReturn:
    """Send the state of a goal of `requester` when it changes, but not its end, until cancelled."""
    last = None
    while True:
        current = station.goals.goal_of(requester)
        if current is not None and current != last:
            last = current
            send({"goal": as_json.goal(current, station.clock.monotonic())})
        await station.clock.sleep(_FOLLOW_PERIOD)
