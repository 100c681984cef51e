"""Carries out what comes through the socket, on the loop of the console."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError, in_one_line
from archo_tui.remote.assistants import Assistants
from archo_tui.remote.follow import follow, follow_goal
from archo_tui.remote.protocol import GONE, LOST, is_stop, words_of
from archo_tui.remote.server import Guest
from archo_tui.remote.waits import LOOK, RanOut, timeout_of, wait_for
from archo_tui.robot import messages
from archo_tui.robot.asker import ASSISTANT, Asker, asked_by
from archo_tui.robot.outcome import NOT_TAKEN_BACK, Code, Outcome, answer_of
from archo_tui.robot.stops import NOT_SENT, RateLimit, Void
from archo_tui.station.station import CALLED_OFF, Station
from archo_tui.verbs import as_data, verbs
from archo_tui.verbs.base import Question, Verb
from archo_tui.verbs.called import choose_verb
from archo_tui.verbs.goals import SendGoal
from archo_tui.verbs.parse import YES, named, parse
from archo_tui.verbs.services import TIMEOUT, Call
from archo_tui.verbs.speak import speak

_MOST_STOPS = 1000  # that are answered: of a flood the last ones
_PATIENCE = 60.0  # s for a person at a shell to answer
_CALLED_OFF = 3.0  # s in which what is called off is seen to end
RAN_OUT = "ran_out"  # in place of an outcome's code: the time that was waited for is over


class Desk:
    """One for each console; knows each client by what it does."""

    def __init__(self, station: Station) -> None:
        self._station, self._robot = station, station.robot
        self.verbs: Mapping[str, Verb] = verbs(self._robot.file, self._robot.snapshot.forms)
        self._assistants = Assistants(station, self.verbs, self._until)
        self._visits: dict[Guest, _Visit] = {}
        self._late_cancels: set[asyncio.Future[None]] = set()  # of work whose time was over
        # STOPs that have not left, and whether somebody is about to send them
        self._stops: deque[tuple[Guest, Any, bool]] = deque(maxlen=_MOST_STOPS)
        self._comes = False
        self._rate_limit = RateLimit()

    # on the server's thread

    def serve(self, client: Guest, request: dict[str, Any], stops: int) -> None:
        """Begin to carry it out; STOP at once, the others when they are due."""
        if is_stop(request):
            is_assistant = request.get("assistant") is True
            self._stops.append((client, request.get("id"), is_assistant))
            if not self._comes:  # else a flood would be as many tasks
                self._comes = True
                self._station.post(self._stop)
        else:
            self._station.post(partial(self._serve, client, request, stops))

    def answer(self, client: Guest, answer: dict[str, Any], stops: int) -> None:
        """What a client says while its request is carried out."""
        self._station.post(partial(self._answered, client, answer))

    def gone(self, client: Guest) -> None:
        """It has left: what it waits for is called off."""
        self._station.post(partial(self._leave, client))

    # on the console's loop

    async def _stop(self) -> None:
        """Send one for all that have come by then; none waits for the answer to another."""
        clock = self._station.clock
        now: list[tuple[Guest, Any, bool]] = []
        try:
            due = clock.monotonic() + self._rate_limit.delay(clock.monotonic())
            while clock.monotonic() < due and not self._robot.stops.superseded:
                await clock.sleep(LOOK)
            self._comes = False
            now = [self._stops.popleft() for _ in range(len(self._stops))]
            if not now:  # another one has taken them along
                return
            self._rate_limit.record(clock.monotonic())
            self._station.ask_no_more()
            with asked_by(self._asker(*now[0][::2])):
                outcome = await self._stopped()
        except asyncio.CancelledError:  # the screen ends: the next one sends it again, and answers
            self._stops.extendleft(reversed(now))
            self._comes = True
            self._station.post(self._stop)
            raise
        for client, number, _ in now:
            client.tell(_result(number, outcome))

    def _asker(self, client: Guest, is_assistant: bool) -> Asker:
        visit = self._visits.get(client)
        return _asker(client, assistant=is_assistant) if visit is None else visit.asker

    async def _stopped(self) -> Outcome:
        try:
            return await self.verbs["stop"].run(self._station, {})
        except Exception as error:  # whatever it is, whoever said it is answered
            return Outcome(Code.REFUSED, in_one_line(error))

    def _visit(self, client: Guest) -> _Visit:
        if client not in self._visits:
            self._visits[client] = _Visit(client)
            self._list_clients()
        return self._visits[client]

    def _list_clients(self) -> None:
        self._station.clients = tuple(visit.asker.source for visit in self._visits.values())
        self._station.look()

    async def _leave(self, client: Guest) -> None:
        visit = self._visits.pop(client, None)
        if visit is None:  # it said nothing
            return
        visit.has_gone = True
        self._list_clients()
        await self._call_off(visit)

    async def _call_off(self, visit: _Visit) -> None:
        """Its goals leave the queue, the one that runs is cancelled: so ends what it waits for."""
        if visit.asked is not None and not visit.asked.done():
            visit.asked.set_result(False)
        ends_with_it = visit.is_assistant and visit.has_gone  # also what it does not wait for
        if visit.task is not None and visit.only_looks:
            visit.is_off = True
            visit.task.cancel()
        elif visit.is_waiting and not visit.leaves:
            ends_with_it = True
        if ends_with_it:
            visit.asker.has_left = True
            await self._station.call_off(visit.asker)

    async def _answered(self, client: Guest, answer: dict[str, Any]) -> None:
        visit = self._visit(client)
        if answer.get("give_up") and visit.task is None:
            client.tell(_result(None, Outcome(Code.DONE, "it had ended")))
        elif answer.get("give_up"):
            asker = visit.asker
            if not (asker.ends or visit.is_assistant):  # nothing was sent, nothing will be
                asker.has_left = True
            await self._call_off(visit)
            # Nothing takes back a request that a service has: only the waiting ends.
            if visit.calls and visit.task is not None:
                visit.is_off = True
                visit.task.cancel()
        elif visit.asked is not None and not visit.asked.done():
            visit.asked.set_result(answer.get("answer") is True)

    async def _serve(self, client: Guest, request: dict[str, Any], stops: int) -> None:
        visit, number = self._visit(client), request.get("id")
        visit.begin(request)
        if visit.is_assistant:
            self._list_clients()
        visit.task = asyncio.current_task()
        try:
            with self._robot.stops.typed_at(stops), asked_by(visit.asker):
                result = await self._obey_in_time(visit, request)
        except Void:
            result = _result(number, Outcome(Code.CANCELLED, NOT_SENT))
        except _Declined as error:
            result = _result(number, Outcome(Code.CANCELLED, str(error)))
        except RanOut as error:
            result = {"id": number, "code": RAN_OUT, "text": str(error)}
        except (ArchoError, ValueError) as error:
            result = _result(number, Outcome(Code.MISUSE, str(error)))
        except Exception as error:  # whatever it is, the console goes on
            said = in_one_line(error)
            self._robot.note("ERROR", "console", f"{visit.asker.source}: {said}")
            result = _result(number, Outcome(Code.REFUSED, said))
        except asyncio.CancelledError:
            said = NOT_TAKEN_BACK if visit.calls else CALLED_OFF
            result = _result(number, Outcome(Code.CANCELLED, said))
            if not visit.is_off:  # the screen ends, or was restarted: its goal is the console's
                result = {"id": number, "code": LOST, "text": GONE}
        finally:
            visit.task, visit.is_waiting = None, False
            client.tell(result)
            client.done()

    async def _obey_in_time(self, visit: _Visit, request: dict[str, Any]) -> dict[str, Any]:
        """The result. Raises RanOut when its time is over; what it has sent is cancelled then."""
        words, timeout = request.get("words"), timeout_of(request)
        waits = isinstance(words, list) and words[:1] == ["wait"]  # which keeps the time itself
        if timeout is None or waits or visit.is_assistant:
            return await self._obey(visit, request)
        work, clock = asyncio.ensure_future(self._obey(visit, request)), self._station.clock
        over = f"not within {timeout:g} s"
        try:
            with suppress(TimeoutError):
                return await clock.wait_for(asyncio.shield(work), timeout)
            if visit.only_looks:
                raise RanOut(f"{timeout:g} s are over")
            if visit.leaves:
                work.add_done_callback(_heed)
                raise RanOut(f"{over}; what was sent goes on")
            if visit.calls:  # nothing takes back a request that a service has
                raise RanOut(f"{over}: the robot may still do it")
            return await self._call_off_late(visit, work, over)
        finally:
            if not visit.leaves:
                work.cancel()

    async def _call_off_late(
        self, visit: _Visit, work: asyncio.Future[dict[str, Any]], over: str
    ) -> dict[str, Any]:
        """Call off work whose time is over; returns its result if that is good after all.

        Clients wait for `_CALLED_OFF` and little more, so this ends then, also while the robot
        has not answered the cancel.

        Raises:
            RanOut: The work did not end well; the text is `over`, and how it ended.
        """
        visit.is_waiting = visit.asker.has_left = True
        cancel = asyncio.ensure_future(self._call_off(visit))
        self._late_cancels.add(cancel)  # the loop holds tasks weakly
        cancel.add_done_callback(self._late_cancels.discard)
        try:
            with suppress(TimeoutError):
                result = await self._station.clock.wait_for(asyncio.shield(work), _CALLED_OFF)
                if result["code"] in ("done", "arrived"):  # at the last moment
                    return result
                raise RanOut(f"{over}: {result['text']}")
        except _Declined:
            raise RanOut(f"{over}: nobody has answered") from None
        raise RanOut(f"{over}; what was sent may still be done")

    async def _obey(self, visit: _Visit, request: dict[str, Any]) -> dict[str, Any]:
        number = request.get("id")
        if visit.is_assistant:
            return await self._assistants.obey(visit.asker, request)
        if request.get("follow"):
            if words_of(request) != ["events"]:
                raise ValueError("only events, and nothing behind it, can be followed")
            await follow(self._station, visit.client.tell, number)
        word, *rest = words_of(request)
        if word == "wait":
            if request.get("wait"):
                raise ValueError("wait has no --wait")
            sent = visit.sent if rest == ["arrived"] else []
            waited = self._arrived(sent) if sent else None
            return _result(number, await wait_for(self._station, self.verbs, rest, request, waited))
        if "--help" in rest:
            verb = named(self.verbs, word)
            return {**_result(number, Outcome(Code.DONE, verb.explained)), "data": verb.options}
        verb, rest = choose_verb(self.verbs, self._station, word, rest)
        if request.get("wait") is True and not verb.has_goals:
            raise ValueError(f"{word} has no --wait: it sends no goals")
        values, yes = parse(verb, self._station, rest)
        visit.calls = isinstance(verb, Call)
        if visit.calls:
            values = {**values, TIMEOUT: timeout_of(request)}
        person = request.get("person") is True
        ask = None if yes else partial(self._ask, visit, number, person)
        asker = visit.asker
        outcome = await speak(self._station, verb, values, partial(self._until, asker), ask)
        self._station.look()
        if asker.ends:
            visit.sent = asker.ends
        if visit.is_waiting and outcome.ok and asker.ends:
            visit.client.tell({"id": number, "said": outcome.text})
            feedback = request.get("feedback") is True
            outcome = await self._wait_for_ends(visit, number, feedback=feedback)
        result = {**_result(number, outcome), "tells": verb.tells}
        told = verb.data(self._station, values) if outcome.ok else None
        answer = answer_of(outcome)
        if answer is not None and word == "call":
            told = await in_daemon(messages.as_data, answer)  # a map has a million values
        if visit.is_waiting and asker.goal is not None:
            told = as_data.goal(asker.goal, self._station.clock.monotonic())
            if isinstance(verb, SendGoal) and asker.goal.result is not None:
                told["result"] = await in_daemon(messages.as_data, asker.goal.result)
                result["tells"] = True
        return result if told is None else {**result, "data": told}

    async def _wait_for_ends(self, visit: _Visit, number: Any, *, feedback: bool) -> Outcome:
        """Wait until all goals of a client have ended; with `feedback`, tell it their states."""
        if not feedback:
            return await _ended(visit.asker.ends)
        work = follow_goal(self._station, visit.asker, visit.client.tell, number)
        following = asyncio.ensure_future(work)
        try:
            return await _ended(visit.asker.ends)
        finally:
            following.cancel()

    @staticmethod
    def _arrived(ends: list[asyncio.Future[Outcome]]) -> Callable[[], Outcome | None]:
        return lambda: _outcome(ends) if all(end.done() for end in ends) else None

    async def _ask(self, visit: _Visit, number: Any, person: bool, question: Question) -> None:
        """Have the person at the shell answer; raises _Declined when it is not yes."""
        text = " ".join(question.text.split())
        if not person:
            raise ArchoError(f"{text} (add {YES} to do it)")
        visit.asked = asyncio.get_running_loop().create_future()
        visit.client.tell({"id": number, "ask": text, "safe": question.safe, "go": question.go})
        try:
            answer = await self._station.clock.wait_for(visit.asked, _PATIENCE)
        except TimeoutError:
            answer = False
        finally:
            visit.asked = None
        if not answer:
            raise _Declined(question.safe.lower())

    async def _until(self, asker: Asker, holds: Callable[[], object], seconds: float) -> None:
        clock = self._station.clock
        end = clock.monotonic() + seconds
        while not (holds() or asker.has_left) and clock.monotonic() < end:
            await clock.sleep(LOOK)


class _Declined(ArchoError):
    """Whoever was asked did not say yes."""


class _Visit:
    """What one client does."""

    def __init__(self, client: Guest) -> None:
        self.client = client
        self.sent: list[asyncio.Future[Outcome]] = []  # the ends of its last goals
        self.asked: asyncio.Future[bool] | None = None
        self.task: asyncio.Task[None] | None = None
        self.is_assistant = self.has_gone = False
        self.begin({})

    def begin(self, request: Mapping[str, Any]) -> None:
        """This is what it asks for now."""
        words = request.get("words")
        if not self.is_assistant:  # which is one from its first word on, and the same to its end
            self.is_assistant = request.get("assistant") is True
            self.asker = _asker(self.client, assistant=self.is_assistant)
        # for the end of its goals, before they are sent: it may be gone by then
        self.is_waiting = request.get("wait") is True
        self.leaves = request.get("leave") is True  # and they go on without it
        self.asker.waits = self.is_assistant or (self.is_waiting and not self.leaves)
        waits = isinstance(words, list) and words[:1] in (["wait"], ["keep"])
        self.calls = False  # a service: its answer is waited for
        self.only_looks = waits or bool(request.get("follow"))  # it commands nothing
        self.is_off = False  # was called off


def _heed(work: asyncio.Future[Any]) -> None:
    """Look how work ended that nobody waits for: else asyncio says that nobody did."""
    if not work.cancelled():
        work.exception()


def _asker(client: Guest, *, assistant: bool = False) -> Asker:
    number = str(client.pid) if client.pid else "unknown"
    return Asker("AI", f"{ASSISTANT} {number}") if assistant else Asker("SHELL", f"pid {number}")


async def _ended(ends: list[asyncio.Future[Outcome]]) -> Outcome:
    """How goals ended, when all have; one that was held, and goes on, has another end."""
    while waited := [end for end in ends if not end.done()]:
        await asyncio.wait(waited[:1])  # which leaves it as it is when this is given up
    return _outcome(ends)


def _outcome(ends: list[asyncio.Future[Outcome]]) -> Outcome:
    """The first that did not arrive, else the last."""
    outcomes = [end.result() for end in ends]
    bad = [outcome for outcome in outcomes if outcome.code != Code.ARRIVED]
    return bad[0] if bad else outcomes[-1]


def _result(number: Any, outcome: Outcome) -> dict[str, Any]:
    return {"id": number, "code": outcome.code.value, "text": outcome.text}
