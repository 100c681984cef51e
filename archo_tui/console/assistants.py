"""The requests of assistants: to read the state, cancel a goal, and ask a person for one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from archo_tui.base.safe_text import harmless, is_deceptive
from archo_tui.client.protocol import timeout_of, words_of
from archo_tui.robot.clients import Requester
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.messages.typed import typed_text
from archo_tui.robot.outcome import WATCHING, Code, Outcome, Report
from archo_tui.robot.state.goal import values_text
from archo_tui.robot_file.model import FormField
from archo_tui.station.approvals import LIFETIME, ApprovalRequest, ApprovalStatus, quoted
from archo_tui.station.station import Station
from archo_tui.text.goal import remaining_text
from archo_tui.verbs import as_json
from archo_tui.verbs.goals import GOALS, Go
from archo_tui.verbs.verb import Verb, parse, prepare_when_found, run_when_ready
from archo_tui.verbs.waits import wait_until

_LOOKS = ("status", "events", "history", "params", "get", "interface", "echo")
_LONGEST_TEXT = 300  # Characters of a goal that a person has to read.
_LONGEST_WAIT = 50.0  # Seconds: tools give up after a minute.


class Assistants:
    """The handler of assistants' requests except STOP; each cancels only its own goals."""

    def __init__(self, station: Station, verbs: Mapping[str, Verb]) -> None:
        self._station, self._verbs = station, verbs

    async def carry_out(self, requester: Requester, request: dict[str, Any]) -> Outcome:
        """Carry out a request of an assistant; verbs that act are refused.

        Raises ArchoError or ValueError for what means nothing here.
        """
        if "ask" in request:
            return await self._request_approval(requester, request["ask"])
        word, *rest = words_of(request)
        if word == "goals" and not rest:
            return Report.of("", self._goals())
        if word == "wait" and rest[:1] == ["request"]:
            return await self._wait_for_request(requester, rest[1:], timeout_of(request))
        if word == "cancel" and not rest:
            return await self._cancel(requester)
        if word not in _LOOKS:
            text = f"an assistant has no {word[:40]}: a person does that at the console"
            return Outcome(Code.REFUSED, text)
        verb = self._verbs[word]
        values, _ = parse(verb, rest)
        return await run_when_ready(self._station, verb, values)

    def _goals(self) -> list[dict[str, Any]]:
        """Return `kind`, `title` and `values` of each goal: what each field takes, by its path."""
        snapshot, found = self._station.robot.snapshot, []
        for verb in self._verbs.values():
            if not isinstance(verb, Go):
                continue
            form, values = snapshot.form(verb.kind), dict[str, Any]()
            for field in snapshot.forms.get(verb.kind.id, ()):
                given = form.get(field.path, FormField())
                about = {name: getattr(given, name) for name in ("label", "low", "high", "unit")}
                known = {name: value for name, value in about.items() if value not in (None, "")}
                values[field.path] = {"type": field.type, **known}
            found.append({"kind": verb.id, "title": verb.title, "values": values})
        return found

    async def _request_approval(self, requester: Requester, wanted: Any) -> Outcome:
        """Ask a person to allow a goal, and reply without waiting for the decision."""
        kind = wanted.get("kind") if isinstance(wanted, dict) else None
        verb = self._verbs.get(kind) if isinstance(kind, str) else None
        if not isinstance(verb, Go):
            kinds = ", ".join(v.id for v in self._verbs.values() if isinstance(v, Go)) or "none"
            raise ValueError(f"kind: the goals of this robot are {kinds}")
        if self._station.robot.watching:
            return Outcome(Code.REFUSED, WATCHING)
        given = wanted.get("values")
        if not isinstance(given, dict):
            raise ValueError("values: expected an object, by name")
        goals = verb.values([f"{name}={typed_text(value)}" for name, value in given.items()])
        (values,) = goals[GOALS]
        prepared = await prepare_when_found(self._station, verb, goals)
        if isinstance(prepared, Outcome):
            return Outcome(Code.REFUSED, prepared.text)
        title = verb.title.lower()
        shown = {path: quoted(value) for path, value in values.items()}
        text = " ".join(filter(None, (title, values_text(verb.kind, shown))))
        typed = [value for value in values.values() if isinstance(value, str)]
        # Otherwise the person would see another goal than the one that is sent.
        if len(text) > _LONGEST_TEXT or harmless(text) != text or any(map(is_deceptive, typed)):
            raise ValueError(
                f"values: more than {_LONGEST_TEXT} characters, or some that are invisible"
            )
        try:
            request = self._station.approvals.request(QueuedGoal(verb.kind, values), text)
        except ValueError as error:
            return Outcome(Code.REFUSED, str(error))
        text = f"request {request.number} waits for a person: {text}"
        return Report.of(text, {"request": request.number, "expires_in": LIFETIME}, Code.ASKED)

    async def _wait_for_request(
        self, requester: Requester, words: list[str], timeout: float | None
    ) -> Outcome:
        """Wait until the assistant's request is denied, void or expired, or its goal has ended.

        `timeout` counts up to 50 s, which is the default.
        """

        def outcome_if_over() -> Outcome | None:
            asked = self._request_of(requester, words)
            if asked.status == ApprovalStatus.WAITING:
                return None
            if asked.status != ApprovalStatus.ALLOWED:
                text = f"request {asked.number} is {asked.status.value}: {asked.reason}"
                return Outcome(Code(asked.status.name.lower()), text.removesuffix(": "))
            if asked.goal_end is None or not asked.goal_end.done():
                return None
            outcome, goal = asked.goal_end.result(), asked.ended_goal
            data = None if goal is None else as_json.goal(goal, self._now)
            return Report.of(outcome.text, data, outcome.code)

        seconds = _LONGEST_WAIT if timeout is None else min(timeout, _LONGEST_WAIT)
        outcome = await wait_until(self._station, outcome_if_over, seconds)
        if outcome.code is Code.RAN_OUT:
            return Outcome(Code.RAN_OUT, self._progress_text(self._request_of(requester, words)))
        return outcome

    def _progress_text(self, request: ApprovalRequest) -> str:
        if request.status == ApprovalStatus.WAITING:
            left = f"{request.seconds_left(self._now):.0f} s left"
            return f"request {request.number} still waits for a person, {left}"
        goal = self._station.robot.snapshot.running_goal
        said = f"request {request.number} was allowed; its goal has not ended yet"
        return ", ".join(filter(None, (said, goal and remaining_text(goal))))

    @property
    def _now(self) -> float:
        return self._station.clock.monotonic()

    def _request_of(self, requester: Requester, words: list[str]) -> ApprovalRequest:
        """Return this assistant's approval request by its number; ValueError if there is none."""
        number = words[0] if len(words) == 1 else ""
        is_number = number.isascii() and number.isdecimal() and len(number) < 10
        request = self._station.approvals.get(int(number)) if is_number else None
        if request is None or request.requester is not requester:
            raise ValueError(f"no request {number[:20]!r} of this assistant")
        return request

    async def _cancel(self, requester: Requester) -> Outcome:
        withdrawn = self._station.approvals.withdraw(requester)
        if withdrawn:
            return Outcome(Code.DONE, f"withdrawn: {withdrawn}")
        if all(end.done() for end in requester.ends):
            text = "no goal of this assistant runs; say stop to stop the robot"
            return Outcome(Code.REFUSED, text)
        # While its goal waits or runs, no other goal does.
        return await self._station.goals.cancel()
