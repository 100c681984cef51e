"""The handler of requests that come through the socket; it works on the console's loop."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any, NoReturn

from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError, in_one_line
from archo_tui.remote.assistants import Assistants
from archo_tui.remote.follow import follow, follow_goal
from archo_tui.remote.protocol import GONE, LOST, RESTARTS, is_stop, words_of
from archo_tui.remote.server import ClientSession
from archo_tui.remote.waits import POLL_PERIOD, RequestTimedOut, timeout_of, wait_for
from archo_tui.robot.clients.requester import ASSISTANT, Requester, on_behalf_of
from archo_tui.robot.messages.text import as_json
from archo_tui.robot.outcome import NOT_TAKEN_BACK, Code, Outcome, answer_of, data_of
from archo_tui.robot.stop.gate import NOT_SENT, RateLimit, Void
from archo_tui.station.goal_driver import CALLED_OFF
from archo_tui.station.station import Station
from archo_tui.verbs import as_data, verbs
from archo_tui.verbs.base import ROBOT_TIMEOUT, Question, Verb
from archo_tui.verbs.called import choose_verb
from archo_tui.verbs.candidates import candidates
from archo_tui.verbs.goals import SendGoal
from archo_tui.verbs.inspect import Echo, FollowedMessage
from archo_tui.verbs.parse import YES, named, parse
from archo_tui.verbs.run_when_ready import run_when_ready
from archo_tui.verbs.services import TIMEOUT, Call

_MAX_STOPS = 1000  # STOPs that are answered: of a flood the last ones.
_ANSWER_TIMEOUT = 60.0  # Seconds for a person at a shell to answer a question.
_CALL_OFF_TIMEOUT = 3.0  # Seconds for the end of work that was called off.
RAN_OUT = "ran_out"  # In place of an outcome's code: the client's timeout is over.


class RequestHandler:
    """The handler of requests on the console's loop; call its public methods on any thread."""

    def __init__(self, station: Station) -> None:
        self._station, self._robot = station, station.robot
        self.verbs: Mapping[str, Verb] = verbs(self._robot.file, self._robot.snapshot.forms)
        self._assistants = Assistants(station, self.verbs, self._until)
        self._clients: dict[ClientSession, _Session] = {}
        self._late_cancels: set[asyncio.Future[None]] = set()  # Of work that ran out of time.
        # Clients whose STOP has not left yet, each with its request's id and whether it is an
        # assistant; and whether a task will send one for all of them.
        self._stops: deque[tuple[ClientSession, Any, bool]] = deque(maxlen=_MAX_STOPS)
        self._stop_is_due = False
        self._rate_limit = RateLimit()

    # Called on the server's thread.

    def serve(self, client: ClientSession, request: dict[str, Any], stops: int) -> None:
        """Begin to carry out a request; a STOP goes before all others.

        STOPs that wait at the same time are sent to the robot as one. A STOP read after the first
        `stops` ones, before the robot gets the request, makes the request void.
        """
        if is_stop(request):
            is_assistant = request.get("assistant") is True
            self._stops.append((client, request.get("id"), is_assistant))
            if not self._stop_is_due:  # One task for all: a flood would be as many tasks.
                self._stop_is_due = True
                self._station.post(self._stop)
        else:
            self._station.post(partial(self._serve, client, request, stops))

    def on_answer(self, client: ClientSession, answer: dict[str, Any], stops: int) -> None:
        self._station.post(partial(self._pass_answer, client, answer))

    def on_client_left(self, client: ClientSession) -> None:
        """Call off the work that a client waits for.

        Goals that it did not wait for, or asked to leave running, run on; those of an assistant do
        not.
        """
        self._station.post(partial(self._end_session, client))

    # Called on the console's loop.

    async def _stop(self) -> None:
        """Send one STOP for all that wait, within the rate limit, and reply to each client.

        An earlier STOP may still be unanswered. Open questions are closed.
        """
        clock = self._station.clock
        now: list[tuple[ClientSession, Any, bool]] = []
        try:
            due = clock.monotonic() + self._rate_limit.delay(clock.monotonic())
            while clock.monotonic() < due and not self._robot.stops.superseded:
                await clock.sleep(POLL_PERIOD)
            self._stop_is_due = False
            now = [self._stops.popleft() for _ in range(len(self._stops))]
            if not now:  # Another task has sent one for them.
                return
            self._rate_limit.record(clock.monotonic())
            self._station.close_questions()
            with on_behalf_of(self._requester(*now[0][::2])):
                outcome = await self._send_stop()
        except asyncio.CancelledError:  # The screen ends: the next one sends it and answers.
            self._stops.extendleft(reversed(now))
            self._stop_is_due = True
            self._station.post(self._stop)
            raise
        for client, number, _ in now:
            client.reply(_result(number, outcome))

    def _requester(self, client: ClientSession, is_assistant: bool) -> Requester:
        session = self._clients.get(client)
        return _requester(client, assistant=is_assistant) if session is None else session.requester

    async def _send_stop(self) -> Outcome:
        try:
            return await self.verbs["stop"].run(self._station, {})
        except Exception as error:  # Whatever failed, the client gets a reply.
            return Outcome(Code.REFUSED, in_one_line(error))

    def _session_of(self, client: ClientSession) -> _Session:
        if client not in self._clients:
            self._clients[client] = _Session(client)
            self._publish_clients()
        return self._clients[client]

    def _publish_clients(self) -> None:
        self._station.clients = tuple(
            session.requester.source for session in self._clients.values()
        )
        self._station.refresh()

    async def _end_session(self, client: ClientSession) -> None:
        session = self._clients.pop(client, None)
        if session is None:  # It requested nothing.
            return
        session.has_gone = True
        self._publish_clients()
        await self._call_off(session)

    async def _call_off(self, session: _Session) -> None:
        """Call off what a client waits for: deny its open question, and end the wait.

        Goals end if the client waits for them and did not ask to leave them running, or is an
        assistant that has left.
        """
        if session.pending_answer is not None and not session.pending_answer.done():
            session.pending_answer.set_result(False)
        ends_with_it = session.is_assistant and session.has_gone
        if session.task is not None and session.is_read_only:
            session.is_called_off = True
            session.task.cancel()
        elif session.is_waiting and not session.keeps_goals:
            ends_with_it = True
        if ends_with_it:
            session.requester.has_left = True
            await self._station.goals.call_off(session.requester)

    async def _pass_answer(self, client: ClientSession, answer: dict[str, Any]) -> None:
        """Pass on the answer to a question, or call the client's request off at a `give_up`.

        A `give_up` without a request gets a reply at once; an answer to no question is ignored.
        """
        session = self._session_of(client)
        if answer.get("give_up") and session.task is None:
            client.reply(_result(None, Outcome(Code.DONE, "it had ended")))
        elif answer.get("give_up"):
            requester = session.requester
            if not (requester.ends or session.is_assistant):  # Nothing was sent; nothing will be.
                requester.has_left = True
            await self._call_off(session)
            # Nothing takes back a request that a service has: only the waiting ends.
            if session.calls_service and session.task is not None:
                session.is_called_off = True
                session.task.cancel()
        elif session.pending_answer is not None and not session.pending_answer.done():
            session.pending_answer.set_result(answer.get("answer") is True)

    async def _serve(self, client: ClientSession, request: dict[str, Any], stops: int) -> None:
        session, number = self._session_of(client), request.get("id")
        session.start_request(request)
        if session.is_assistant:
            self._publish_clients()
        session.task = asyncio.current_task()
        try:
            with self._robot.stops.typed_at(stops), on_behalf_of(session.requester):
                result = await self._carry_out_in_time(session, request)
        except Void:
            result = _result(number, Outcome(Code.CANCELLED, NOT_SENT))
        except _Declined as error:
            result = _result(number, Outcome(Code.CANCELLED, str(error)))
        except RequestTimedOut as error:
            result = {"id": number, "code": RAN_OUT, "text": str(error)}
        except (ArchoError, ValueError) as error:
            result = _result(number, Outcome(Code.MISUSE, str(error)))
        except Exception as error:  # Whatever failed, the console goes on.
            text = in_one_line(error)
            self._robot.note("ERROR", "console", f"{session.requester.source}: {text}")
            result = _result(number, Outcome(Code.REFUSED, text))
        except asyncio.CancelledError:
            text = NOT_TAKEN_BACK if session.calls_service else CALLED_OFF
            result = _result(number, Outcome(Code.CANCELLED, text))
            # Else the screen ends or restarts, and the console keeps the goal.
            if not session.is_called_off:
                text = RESTARTS if self._station.is_restarting else GONE
                result = {"id": number, "code": LOST, "text": text}
        finally:
            if session.requester.waits and not session.is_assistant:
                self._station.goals.take_out(session.requester)
            session.task, session.is_waiting = None, False
            client.reply(result)
            client.on_request_ended()

    async def _carry_out_in_time(
        self, session: _Session, request: dict[str, Any]
    ) -> dict[str, Any]:
        """Carry out a request within its `timeout`, and return the result that the client gets."""
        words, timeout = request.get("words"), timeout_of(request)
        waits = isinstance(words, list) and words[:1] == ["wait"]  # Keeps the timeout itself.
        if timeout is None or waits or session.is_assistant:
            return await self._carry_out(session, request)
        work, clock = asyncio.ensure_future(self._carry_out(session, request)), self._station.clock
        over = f"not within {timeout:g} s"
        try:
            with suppress(TimeoutError):
                return await clock.wait_for(asyncio.shield(work), timeout)
            if session.is_read_only:
                raise RequestTimedOut(f"{timeout:g} s are over")
            if session.keeps_goals:
                work.add_done_callback(_retrieve_exception)
                raise RequestTimedOut(f"{over}; what was sent goes on")
            if session.calls_service:  # Nothing takes back a request that a service has.
                raise RequestTimedOut(f"{over}: the robot may still do it")
            return await self._call_off_late(session, work, over)
        finally:
            if not session.keeps_goals:
                work.cancel()

    async def _call_off_late(
        self, session: _Session, work: asyncio.Future[dict[str, Any]], over: str
    ) -> dict[str, Any]:
        """Call off work whose time is over, and return its result if it has succeeded after all.

        Returns within 3 s: an unanswered cancel goes on alone. RequestTimedOut begins with `over`.
        """
        session.is_waiting = session.requester.has_left = True
        cancel = asyncio.ensure_future(self._call_off(session))
        self._late_cancels.add(cancel)  # The loop holds tasks weakly.
        cancel.add_done_callback(self._late_cancels.discard)
        try:
            with suppress(TimeoutError):
                result = await self._station.clock.wait_for(asyncio.shield(work), _CALL_OFF_TIMEOUT)
                if result["code"] in ("done", "arrived"):  # At the last moment.
                    return result
                raise RequestTimedOut(f"{over}: {result['text']}")
        except _Declined:
            raise RequestTimedOut(f"{over}: nobody has answered") from None
        raise RequestTimedOut(f"{over}; what was sent may still be done")

    async def _carry_out(self, session: _Session, request: dict[str, Any]) -> dict[str, Any]:
        """Carry out a request without a time limit; following events or a topic never returns."""
        number = request.get("id")
        if session.is_assistant:
            return await self._assistants.carry_out(session.requester, request)
        if "complete" in request:
            words = words_of({"words": request["complete"]})
            found = candidates(self.verbs, self._station, words)
            return {**_result(number, Outcome(Code.DONE, "")), "data": found}
        if request.get("follow"):
            if words_of(request)[0] == "echo":
                await self._follow_topic(session, request)
            if words_of(request) != ["events"]:
                raise ValueError("only events can be followed, without further words")
            await follow(self._station, session.client.reply, number)
        word, *rest = words_of(request)
        if word == "wait":
            if request.get("wait"):
                raise ValueError("wait has no --wait")
            sent = session.sent if rest == ["arrived"] else []
            waited = self._check_of_goals(sent) if sent else None
            return _result(number, await wait_for(self._station, self.verbs, rest, request, waited))
        if "--help" in rest:
            verb = named(self.verbs, word)
            return {**_result(number, Outcome(Code.DONE, verb.help_line)), "data": verb.options}
        verb, rest = choose_verb(self.verbs, self._station, word, rest)
        if request.get("wait") is True and not verb.has_goals:
            raise ValueError(f"{word} has no --wait: it sends no goals")
        values, yes = parse(verb, self._station, rest)
        session.calls_service = isinstance(verb, Call)
        if session.calls_service:
            values = {**values, TIMEOUT: timeout_of(request)}
        person = request.get("person") is True
        ask = None if yes else partial(self._ask, session, number, person)
        requester = session.requester
        outcome = await run_when_ready(
            self._station, verb, values, partial(self._until, requester), ask
        )
        self._station.refresh()
        if requester.ends:
            session.sent = requester.ends
        if session.is_waiting and outcome.ok and requester.ends:
            session.client.reply({"id": number, "said": outcome.text})
            feedback = request.get("feedback") is True
            outcome = await self._wait_for_ends(session, number, feedback=feedback)
            if self._station.is_restarting and outcome.code != Code.ARRIVED:
                outcome = outcome._replace(text=f"{outcome.text}: the console restarts")
        result = {**_result(number, outcome), "tells": verb.tells}
        data = data_of(outcome)
        if data is None and outcome.ok:
            data = verb.data(self._station, values)
        answer = answer_of(outcome)
        if answer is not None and word == "call":
            data = await in_daemon(as_json, answer)  # A map has a million values.
        if session.is_waiting and requester.goal is not None:
            data = as_data.goal(requester.goal, self._station.clock.monotonic())
            if isinstance(verb, SendGoal) and requester.goal.result is not None:
                data["result"] = await in_daemon(as_json, requester.goal.result)
                result["tells"] = True
        return result if data is None else {**result, "data": data}

    async def _follow_topic(self, session: _Session, request: dict[str, Any]) -> NoReturn:
        """Send the client each message of a topic until the task is cancelled.

        Messages are left out beyond five a second, and while the client has not read all replies.
        """
        station, client, number = self._station, session.client, request.get("id")
        verb = self.verbs["echo"]
        assert isinstance(verb, Echo)
        values, _ = parse(verb, station, words_of(request)[1:])
        left = ROBOT_TIMEOUT - station.age
        await self._until(session.requester, lambda: verb.is_ready(station, values), left)
        for_program = request.get("as_text") is not True

        def show(shown: FollowedMessage) -> None:
            message = {"message": shown.data} if for_program else {"text": shown.text}
            client.reply({"id": number, **message, "left_out": shown.left_out})

        await verb.follow(
            station,
            values,
            show,
            lambda why: client.reply({"id": number, "said": why}),
            for_program=for_program,
            has_room=lambda: not client.is_behind,
        )

    async def _wait_for_ends(self, session: _Session, number: Any, *, feedback: bool) -> Outcome:
        if not feedback:
            return await _wait_for_all(session.requester.ends)
        work = follow_goal(self._station, session.requester, session.client.reply, number)
        following = asyncio.ensure_future(work)
        try:
            return await _wait_for_all(session.requester.ends)
        finally:
            following.cancel()

    @staticmethod
    def _check_of_goals(ends: list[asyncio.Future[Outcome]]) -> Callable[[], Outcome | None]:
        return lambda: _combined_outcome(ends) if all(end.done() for end in ends) else None

    async def _ask(self, session: _Session, number: Any, person: bool, question: Question) -> None:
        """Ask the person at the shell: ArchoError if nobody is there, _Declined without a yes."""
        text = " ".join(question.text.split())
        if not person:
            raise ArchoError(f"{text} (add {YES} to do it)")
        session.pending_answer = asyncio.get_running_loop().create_future()
        session.client.reply({"id": number, "ask": text, "safe": question.safe, "go": question.go})
        try:
            answer = await self._station.clock.wait_for(session.pending_answer, _ANSWER_TIMEOUT)
        except TimeoutError:
            answer = False
        finally:
            session.pending_answer = None
        if not answer:
            raise _Declined(question.safe.lower())

    async def _until(
        self, requester: Requester, holds: Callable[[], object], seconds: float
    ) -> None:
        clock = self._station.clock
        end = clock.monotonic() + seconds
        while not (holds() or requester.has_left) and clock.monotonic() < end:
            await clock.sleep(POLL_PERIOD)


class _Declined(ArchoError):
    """The error for a question that was not answered with yes."""


class _Session:
    """The state of one client: its request, its goals, and its name in events."""

    def __init__(self, client: ClientSession) -> None:
        self.client = client
        # Of its last goals, also after its request ended.
        self.sent: list[asyncio.Future[Outcome]] = []
        self.pending_answer: asyncio.Future[bool] | None = None  # None while nothing is asked.
        self.task: asyncio.Task[None] | None = None  # None between requests.
        self.is_assistant = self.has_gone = False
        self.start_request({})

    def start_request(self, request: Mapping[str, Any]) -> None:
        """Set the attributes for the next request; an assistant keeps its requester for all."""
        words = request.get("words")
        if not self.is_assistant:
            self.is_assistant = request.get("assistant") is True
            self.requester = _requester(self.client, assistant=self.is_assistant)
        # Set before the goals are sent: the client may have left by the time they are.
        self.is_waiting = request.get("wait") is True
        self.keeps_goals = request.get("leave") is True
        self.requester.waits = self.is_assistant or (self.is_waiting and not self.keeps_goals)
        waits = isinstance(words, list) and words[:1] in (["wait"], ["keep"], ["echo"], ["hz"])
        self.calls_service = False
        # So cancelling the task calls it off.
        self.is_read_only = waits or bool(request.get("follow"))
        self.is_called_off = False  # True once the task was cancelled to call its request off.


def _retrieve_exception(work: asyncio.Future[Any]) -> None:
    """Retrieve the exception of work that nobody waits for, so that asyncio logs no warning."""
    if not work.cancelled():
        work.exception()


def _requester(client: ClientSession, *, assistant: bool = False) -> Requester:
    number = str(client.pid) if client.pid else "unknown"
    return (
        Requester("AI", f"{ASSISTANT} {number}")
        if assistant
        else Requester("SHELL", f"pid {number}")
    )


async def _wait_for_all(ends: list[asyncio.Future[Outcome]]) -> Outcome:
    """Wait for the ends of all goals, and return their combined outcome.

    A held goal that is continued gets a new future in `ends`, which is waited for, too.
    """
    while waited := [end for end in ends if not end.done()]:
        await asyncio.wait(waited[:1])  # Cancels no end when this is cancelled.
    return _combined_outcome(ends)


def _combined_outcome(ends: list[asyncio.Future[Outcome]]) -> Outcome:
    """Return the outcome of the first goal that did not arrive, else that of the last goal."""
    outcomes = [end.result() for end in ends]
    bad = [outcome for outcome in outcomes if outcome.code != Code.ARRIVED]
    return bad[0] if bad else outcomes[-1]


def _result(number: Any, outcome: Outcome) -> dict[str, Any]:
    return {"id": number, "code": outcome.code.value, "text": outcome.text}
