"""The steps of running a verb, from its values to its outcome, for every frontend."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.stop.gate import Void
from archo_tui.station.station import Station
from archo_tui.verbs.base import ANSWERS, ROBOT_TIMEOUT, Question, Values, Verb

# Waits until a condition holds, for a number of seconds at most.
Until = Callable[[Callable[[], object], float], Awaitable[None]]
# Returns if the answer is yes; raises ArchoError if it is not, or if nobody can be asked.
Ask = Callable[[Question], Awaitable[None]]


async def run_when_ready(
    station: Station, verb: Verb, values: Values, until: Until, ask: Ask | None
) -> Outcome:
    """Run a verb once the robot is found, earlier requests are answered, and the person agrees.

    The waits end at ROBOT_TIMEOUT seconds after the start, and after ANSWERS seconds: the verb is
    tried then all the same. `ask` is None if `--yes` has answered. Raises ArchoError, ValueError,
    and Void if a STOP was read meanwhile, except for verbs that change nothing or survive a STOP.
    """
    acts, gate = verb.acts_with(values), station.robot.stops.gate()
    is_void = acts and not verb.survives_stop

    def is_found() -> bool:
        return (is_void and gate.is_shut) or verb.is_ready(station, values)

    def is_answered() -> bool:
        return (is_void and gate.is_shut) or verb.is_answered(station)

    if not (acts and station.robot.watching):  # A watching console runs nothing anyway.
        left = ROBOT_TIMEOUT - station.age
        if left > 0:
            await until(is_found, left)
        await until(is_answered, ANSWERS)
        if is_void:
            gate()
    refusal = verb.refusal(station) if acts else verb.disabled_reason(station)
    if refusal:
        return Outcome(Code.WATCHING if station.robot.watching else Code.REFUSED, refusal)
    values = await verb.prepare(station, values)
    question = verb.question(station, values)
    if question is not None and question.go and ask is not None:
        await ask(question)
        if is_void and gate.is_shut:
            raise Void
    return await verb.run(station, values)
