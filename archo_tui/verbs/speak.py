"""A verb from words to outcome, whoever typed them."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.stops import Void
from archo_tui.station.station import Station
from archo_tui.verbs.base import ANSWERS, PATIENCE, Question, Values, Verb

# waits until that holds, or so many seconds
Until = Callable[[Callable[[], object], float], Awaitable[None]]
# returns when the answer is yes; raises ArchoError when it is not, or nobody is there to ask
Ask = Callable[[Question], Awaitable[None]]


async def speak(
    station: Station, verb: Verb, values: Values, until: Until, ask: Ask | None
) -> Outcome:
    """Do it, if it can be done: waits for a robot that was only just found, asks what is asked.

    It also waits for the answers that decide about it (`Verb.is_answered`).
    Without `ask` it is answered already. Raises ArchoError and ValueError with one line for what
    is wrong, and Void when a STOP was read meanwhile.
    """
    acts, gate = verb.acts_with(values), station.robot.stops.gate()
    is_void = acts and not verb.survives_stop

    def is_found() -> bool:
        return (is_void and gate.is_shut) or verb.is_ready(station, values)

    def is_answered() -> bool:
        return (is_void and gate.is_shut) or verb.is_answered(station)

    if not (acts and station.robot.watching):  # else nothing will be done
        left = PATIENCE - station.age
        if left > 0:
            await until(is_found, left)
        await until(is_answered, ANSWERS)
        if is_void:
            gate()
    refusal = verb.refusal(station) if acts else verb.blocked(station)
    if refusal:
        return Outcome(Code.WATCHING if station.robot.watching else Code.REFUSED, refusal)
    values = await verb.prepare(station, values)
    question = verb.asks(station, values)
    if question is not None and question.go and ask is not None:
        await ask(question)
        if is_void and gate.is_shut:
            raise Void
    return await verb.run(station, values)
