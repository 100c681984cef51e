"""The requests of assistants: to look, to cancel a goal, and to ask a person for one."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from archo_tui.remote.protocol import words_of
from archo_tui.remote.waits import RanOut, timeout_of, wait_for
from archo_tui.robot import forms
from archo_tui.robot.outcome import WATCHING, Code, Outcome, data_of
from archo_tui.robot.parameter_values import typed_text
from archo_tui.robot.requester import Requester
from archo_tui.robot.state import values_text
from archo_tui.safe_text import harmless, hides
from archo_tui.station.approval_requests import LIFETIME, ApprovalRequest, ApprovalStatus, quoted
from archo_tui.station.queue import QueuedGoal
from archo_tui.station.station import Station
from archo_tui.verbs import as_data
from archo_tui.verbs.base import PATIENCE, Verb
from archo_tui.verbs.goals import GOALS, Go
from archo_tui.verbs.parse import parse, schema

# Waits until a condition holds, the assistant has left, or so many seconds have passed.
Until = Callable[[Requester, Callable[[], object], float], Awaitable[None]]
_LOOKS = ("status", "events", "history", "params", "get", "interface", "echo")
_LONGEST_TEXT = 300  # Characters of a goal that a person has to read.
_LONGEST_WAIT = 50.0  # Seconds: tools give up after a minute.
ASKED = "asked"  # In place of an outcome's code: a person has to decide.


class Assistants:
    """The handler of all assistants' requests; each assistant sees only its own.

    A STOP of an assistant does not come here: it is carried out as anybody's.
    """

    def __init__(self, station: Station, verbs: Mapping[str, Verb], until: Until) -> None:
        """Make the handler.

        Args:
            station: The station that knows the robot.
            verbs: All verbs, by id.
            until: Waits for a condition.
        """
        self._station, self._verbs, self._until = station, verbs, until

    async def obey(self, requester: Requester, request: dict[str, Any]) -> dict[str, Any]:
        """Carry out a request of an assistant, and return the result.

        Raises:
            RanOut: The timeout is over.
            ValueError: The request means nothing here.
        """
        number = request.get("id")
        if "ask" in request:
            return {"id": number, **await self._ask(requester, request["ask"])}
        word, *rest = words_of(request)
        if word == "goals" and not rest:
            return {"id": number, "code": "done", "text": "", "data": self._goals()}
        if word == "wait" and rest[:1] == ["request"]:
            return {"id": number, **await self._wait(requester, rest[1:], request)}
        if word == "cancel" and not rest:
            outcome = await self._cancel(requester)
            return {"id": number, "code": outcome.code.value, "text": outcome.text}
        if word not in _LOOKS:
            said = f"an assistant has no {word[:40]}: a person does that at the console"
            return {"id": number, "code": Code.REFUSED.value, "text": said}
        verb = self._verbs[word]
        values, _ = parse(verb, self._station, rest)
        values = await verb.prepare(self._station, values)
        outcome = await verb.run(self._station, values)
        result = {"id": number, "code": outcome.code.value, "text": outcome.text}
        data = data_of(outcome)
        if data is None and outcome.ok:
            data = verb.data(self._station, values)
        return result if data is None else {**result, "data": data}

    def _goals(self) -> list[dict[str, Any]]:
        """Return the kinds of goals, each with the JSON schema of its values by dotted path."""
        snapshot, found = self._station.robot.snapshot, []
        for verb in self._verbs.values():
            if isinstance(verb, Go):
                said = schema(verb, snapshot)
                paths = [field.path for field in snapshot.forms.get(verb.kind.id, ())]
                named = zip(paths, said["properties"].items(), strict=False)
                said["properties"] = {path: {"title": label, **one} for path, (label, one) in named}
                said["required"] = paths
                found.append({"kind": verb.id, "title": verb.title, "schema": said})
        return found

    async def _ask(self, requester: Requester, wanted: Any) -> dict[str, Any]:
        """Ask a person for a goal; the result tells the number of that approval request."""
        kind = wanted.get("kind") if isinstance(wanted, dict) else None
        verb = self._verbs.get(kind) if isinstance(kind, str) else None
        if not isinstance(verb, Go):
            kinds = ", ".join(v.id for v in self._verbs.values() if isinstance(v, Go)) or "none"
            raise ValueError(f"kind: the goals of this robot are {kinds}")
        if self._station.robot.watching:
            return {"code": Code.REFUSED.value, "text": WATCHING}
        values = self._values(verb, wanted.get("values"))
        goals = {GOALS: [values]}
        left = PATIENCE - self._station.age
        await self._until(requester, lambda: verb.is_ready(self._station, goals), left)
        await verb.prepare(self._station, goals)
        refusal = verb.refusal(self._station)
        if refusal:
            return {"code": Code.REFUSED.value, "text": refusal}
        title = verb.title.lower()
        shown = {path: quoted(value) for path, value in values.items()}
        text = " ".join(filter(None, (title, values_text(verb.kind, shown))))
        typed = [value for value in values.values() if isinstance(value, str)]
        # Otherwise the person would see another goal than the one that is sent.
        if len(text) > _LONGEST_TEXT or harmless(text) != text or any(map(hides, typed)):
            raise ValueError(
                f"values: more than {_LONGEST_TEXT} characters, or some that are invisible"
            )
        try:
            one = self._station.approvals.request(QueuedGoal(verb.kind, values), text)
        except ValueError as error:
            return {"code": Code.REFUSED.value, "text": str(error)}
        said = f"request {one.number} waits for a person: {text}"
        return {
            "code": ASKED,
            "text": said,
            "data": {"request": one.number, "expires_in": LIFETIME},
        }

    def _values(self, verb: Go, given: Any) -> dict[str, Any]:
        """Return the values of a goal by dotted path, each of its field's type.

        Raises:
            ValueError: One is missing, unknown, or not of its type.
        """
        fields = self._station.robot.snapshot.forms.get(verb.kind.id)
        if fields is None:
            raise ValueError(f"{verb.kind.type} is not installed here")
        if not isinstance(given, dict):
            raise ValueError("values: expected an object, by name")
        paths = [field.path for field in fields]
        for name in given:
            if name not in paths:
                raise ValueError(f"values: no {name[:40]!r}; there are {', '.join(paths)}")
        missing = [path for path in paths if path not in given]
        if missing:
            raise ValueError(f"values: {', '.join(missing)} is missing")
        texts: dict[str, str] = {}
        for path in paths:
            if isinstance(given[path], (dict, list)) or given[path] is None:
                raise ValueError(f"values: {path} is not a number, a text, true or false")
            texts[path] = typed_text(given[path])
        return forms.parse_all(fields, verb.kind.form, texts)

    async def _wait(
        self, requester: Requester, words: list[str], request: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Wait until a person has decided, and an allowed goal has ended."""
        one = self._own(requester, words)
        timeout = timeout_of(request)
        seconds = _LONGEST_WAIT if timeout is None else min(timeout, _LONGEST_WAIT)

        def over() -> Outcome | None:
            now = self._own(requester, words)
            if now.status == ApprovalStatus.WAITING:
                return None
            if now.status == ApprovalStatus.ALLOWED:
                return (
                    now.goal_end.result()
                    if now.goal_end is not None and now.goal_end.done()
                    else None
                )
            return Outcome(Code.CANCELLED, now.reason)

        try:
            outcome = await wait_for(self._station, self._verbs, [], {"timeout": seconds}, over)
        except RanOut:
            raise RanOut(self._progress_text(self._own(requester, words))) from None
        one = self._own(requester, words)
        if one.status != ApprovalStatus.ALLOWED:
            text = f"request {one.number} is {one.status.value}: {one.reason}".removesuffix(": ")
            return {"code": one.status.name.lower(), "text": text}
        goal = one.ended_goal
        said = {"code": outcome.code.value, "text": outcome.text}
        return said if goal is None else {**said, "data": as_data.goal(goal, self._now)}

    def _progress_text(self, one: ApprovalRequest) -> str:
        if one.status == ApprovalStatus.WAITING:
            left = f"{one.seconds_left(self._now):.0f} s left"
            return f"request {one.number} still waits for a person, {left}"
        goal = self._station.robot.snapshot.running_goal
        left = "" if goal is None or goal.remaining is None else f", {goal.remaining:.1f} left"
        return f"request {one.number} was allowed; its goal has not ended yet{left}"

    @property
    def _now(self) -> float:
        return self._station.clock.monotonic()

    def _own(self, requester: Requester, words: list[str]) -> ApprovalRequest:
        """Return the assistant's approval request whose number is typed.

        Raises:
            ValueError: It has none of that number.
        """
        number = words[0] if len(words) == 1 else ""
        is_number = number.isascii() and number.isdecimal() and len(number) < 10
        one = self._station.requests.get(int(number)) if is_number else None
        if one is None or one.requester is not requester:
            raise ValueError(f"no request {number[:20]!r} of this assistant")
        return one

    async def _cancel(self, requester: Requester) -> Outcome:
        withdrawn = self._station.approvals.withdraw(requester)
        if withdrawn:
            return Outcome(Code.DONE, f"withdrawn: {withdrawn}")
        if all(end.done() for end in requester.ends):
            said = "no goal of this assistant runs; say stop to stop the robot"
            return Outcome(Code.REFUSED, said)
        # While its goal waits or runs, no other goal does.
        return await self._station.goals.cancel()
