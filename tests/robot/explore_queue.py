"""Every state of the queue of goals in small worlds: `python -m tests.robot.explore_queue`.

A person and a client that waits type lists of goals; the robot accepts, refuses or does not answer,
and its goals end one way or the other; STOP, release, cancel, skip, continue, an alarm, another
client's goal, the client's leaving, the end of the screen and a restart come in between, in every
order. Each state is checked against the promises of docs/queue.md and docs/stop.md.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from enum import Enum, auto
from functools import partial
from types import ModuleType
from typing import Any, NamedTuple

from archo_tui.robot.goals import queue as the_machine
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Goal, Phase
from archo_tui.robot.state.readings import Motion
from archo_tui.robot.state.snapshot import Snapshot
from tests.robot.exploring import Found, breadth_first, promise
from tests.support.archo import ARCHO, SHELF


class Stage(Enum):
    """How far a goal has come."""

    WAITING = auto()
    HELD = auto()
    ON_ITS_WAY = auto()
    UNDERWAY = auto()
    SETTLED = auto()


def stage(queue: Any, number: int) -> Stage:
    """How far the goal of that number has come."""
    if any(goal.number == number for goal in queue.waiting):
        return Stage.HELD if queue.hold_reason else Stage.WAITING
    if queue.coming is not None and queue.coming.goal.number == number:
        return Stage.ON_ITS_WAY
    is_underway = any(goal.number == number for goal, _ in queue.underway)
    return Stage.UNDERWAY if is_underway else Stage.SETTLED


class Client(NamedTuple):
    """One that types goals."""

    name: str
    waits: bool = False


YOU, SHELL = Client("you"), Client("shell", waits=True)


class Sent(NamedTuple):
    """A goal that the robot has heard of."""

    phase: Phase
    mine: bool = True
    number: int = 0  # In the queue; 0 for one that is not from it.


class World(NamedTuple):
    """All there is, with the queue in it."""

    queue: Any  # machine.GoalQueue
    to_type: tuple[tuple[Client, int], ...]  # Lists, by who types them and their lengths.
    stops_left: int = 0
    alarms_left: int = 0
    others_left: int = 0
    ends_left: int = 0  # Of the screen.
    restarts_left: int = 0
    leaves_left: int = 0
    cancels_left: int = 0
    robot: tuple[Sent, ...] = ()
    stops: int = 0  # Read so far.
    is_stopped: bool = False  # As the console has heard.
    stops_heard: int = 0
    must_ask: bool = False  # What waits now waits for the operator.
    has_alarm: bool = False
    has_left: bool = False  # The client that waits.
    # What was done, by the goals' numbers.
    sent: tuple[int, ...] = ()
    answered: tuple[int, ...] = ()
    settled: tuple[int, ...] = ()
    typed: tuple[tuple[int, int, Client], ...] = ()  # Number, list and client of each goal.
    lost: tuple[int, ...] = ()  # By the end of the screen, or a restart.
    refused: tuple[int, ...] = ()  # Lists whose first goal was refused.
    cancelling: tuple[int, ...] = ()  # Goals whose requester is gone, by number.


def begin(*lists: tuple[Client, int], module: ModuleType = the_machine, **limits: Any) -> World:
    """Return a world in which nothing has happened."""
    return World(module.GoalQueue(), lists, **limits)


def shown(world: World) -> Snapshot:
    goals = [
        Goal(SHELF, {"shelf_number": 1}, sent.phase, 0.0, 0.0, mine=sent.mine, number=place)
        for place, sent in enumerate(world.robot, 1)
    ]
    running = [goal for goal in goals if goal.is_running]
    ended = [goal for goal in reversed(goals) if not goal.is_running]
    first = next((goal for goal in running if goal.mine), next(iter(running or ended), None))
    return Snapshot(
        file=ARCHO, goal=first, history=tuple(ended), motion=Motion(stopped=world.is_stopped)
    )


def done(world: World, queue: Any) -> World:
    """Take the next state of the queue, and do what it says."""
    module = sys.modules[type(queue).__module__]
    todo, queue = queue.todo, queue._replace(todo=())
    before = world.queue.hold_reason
    if before and queue.hold_reason and before != queue.hold_reason:
        is_known = queue.hold_reason in ("STOP", "low battery", "was: low battery")
        promise(is_known, "a queue that is held keeps its reason")
    world = world._replace(queue=queue)
    for deed in todo:
        if deed.do is module.QueueEffect.NOTE:
            continue
        number = deed.goal.number
        if deed.do is module.QueueEffect.SEND:
            promise(number not in world.sent or number in _put_back(world), "a goal is sent once")
            running = [sent for sent in world.robot if sent.mine and _runs(sent)]
            promise(not running, "no goal is sent while another one of ours runs")
            if queue.coming.waited:
                promise(deed.goal.stop_count >= world.stops, "no goal from before a STOP is sent")
                promise(not world.is_stopped, "the queue sends nothing to a stopped robot")
                promise(not queue.hold_reason, "a held queue sends nothing")
                promise(not world.must_ask, "only the operator continues")
            world = world._replace(sent=(*world.sent, number))
        elif deed.do is module.QueueEffect.ANSWER:
            world = world._replace(answered=(*world.answered, number))
            if not deed.outcome.ok:
                world = world._replace(must_ask=bool(queue.waiting))
        elif deed.do is module.QueueEffect.CANCEL:
            world = world._replace(cancelling=(*world.cancelling, number))
        elif deed.do is module.QueueEffect.SETTLE and deed.outcome.code is not Code.HELD:
            promise(number not in world.settled, "a goal has one outcome")
            world = world._replace(settled=(*world.settled, number))
    return world if queue.waiting else world._replace(must_ask=False)


def _put_back(world: World) -> list[int]:
    """Goals that were answered, and neither settled nor accepted: a STOP held them."""
    accepted = [sent.number for sent in world.robot]
    return [n for n in world.answered if n not in (*world.settled, *accepted)]


def _runs(sent: Sent) -> bool:
    return sent.phase in (Phase.MOVING, Phase.UNKNOWN)


def look(world: World) -> World:
    alarms = frozenset({"low battery"} if world.has_alarm else ())
    module = sys.modules[type(world.queue).__module__]
    holding = module.Holding("low battery" if world.has_alarm else "", alarms)
    return done(world, world.queue.seen(shown(world), 0.0, world.stops, holding))


# What happens.


def type_list(world: World) -> World:
    (client, length), *rest = world.to_type
    module = sys.modules[type(world.queue).__module__]
    number = world.queue.submitted + 1
    goals: list[Any] = [
        module.QueuedGoal(SHELF, {"shelf_number": number + place}, world.stops, client)
        for place in range(length)
    ]
    typed = tuple((number + place, number, client) for place in range(length))
    world = world._replace(to_type=tuple(rest), typed=(*world.typed, *typed))
    return done(world, world.queue.submit(goals, shown(world), is_stopped=world.is_stopped))


def begin_sending(world: World) -> World:
    if world.queue.coming.is_called_off:
        return done(world, world.queue.answered(Outcome(Code.CANCELLED, "")))
    return done(world, world.queue.hand_over())


def answer(code: Code, world: World) -> World:
    coming = world.queue.coming
    goal, robot = coming.goal, world.robot
    is_shown = goal.number in [sent.number for sent in robot]
    if code is Code.ACCEPTED and not is_shown:
        robot = (*robot, Sent(Phase.MOVING, number=goal.number))
    elif code is Code.TIMEOUT and not is_shown:
        robot = (*robot, Sent(Phase.UNKNOWN, number=goal.number))
    elif code is Code.REFUSED and goal.is_first:
        world = world._replace(refused=(*world.refused, goal.list_number))
    world = world._replace(robot=robot)
    return done(world, world.queue.answered(Outcome(code, "")))


def take(world: World) -> World:
    """The robot's feedback shows the goal before its answer comes."""
    return world._replace(robot=(*world.robot, Sent(Phase.MOVING, number=_coming(world))))


def _coming(world: World) -> int:
    return world.queue.coming.goal.number if world.queue.coming else 0


def end_goal(place: int, phase: Phase, world: World) -> World:
    robot = list(world.robot)
    robot[place] = robot[place]._replace(phase=phase)
    is_failure = robot[place].mine and phase is not Phase.ARRIVED
    must_ask = world.must_ask or (is_failure and bool(world.queue.waiting))
    return world._replace(robot=tuple(robot), must_ask=must_ask)


def stop(world: World) -> World:
    must_ask = world.must_ask or bool(world.queue.waiting)
    left = world.stops_left - 1
    return world._replace(stops=world.stops + 1, stops_left=left, must_ask=must_ask)


def hear_stop(world: World) -> World:
    world = world._replace(stops_heard=world.stops, is_stopped=True)
    for place, sent in enumerate(world.robot):
        if _runs(sent):
            world = end_goal(place, Phase.ABORTED, world)
    return world


def release(world: World) -> World:
    return world._replace(is_stopped=False)


def resume(world: World) -> World:
    world = world._replace(must_ask=False)
    world = look(done(world, world.queue.resume(world.stops)))
    is_held = bool(world.queue.hold_reason)
    promise(is_held == (world.is_stopped or world.has_alarm), "the operator can continue")
    return world


def skip(world: World) -> World:
    return done(world, world.queue.skip())


def cancel(world: World) -> World:
    after = world.queue.call_off()
    world = world._replace(cancels_left=world.cancels_left - 1)
    if after is not world.queue:
        is_sent = world.queue.coming.is_handed_over
        promise(not is_sent, "a goal that is handed over is cancelled by a request")
        return done(world, after)
    for place, sent in enumerate(world.robot):
        if _runs(sent):
            return end_goal(place, Phase.CANCELLED, world)
    return world


def leave(world: World) -> World:
    world = world._replace(has_left=True, leaves_left=world.leaves_left - 1)
    world = done(world, world.queue.leave(SHELL))
    theirs = [goal.number for goal, _ in world.queue.underway if goal.requester == SHELL]
    return world._replace(cancelling=(*world.cancelling, *theirs))


def end_screen(world: World) -> World:
    """The screen ends, and another one begins."""
    coming = world.queue.coming
    world = world._replace(ends_left=world.ends_left - 1)
    if not coming.is_handed_over:
        return done(world, world.queue.drop())
    if coming.goal.number not in [sent.number for sent in world.robot]:
        world = take(world)
    world = world._replace(lost=(*world.lost, coming.goal.number))
    return done(world, world.queue.lose())


def restart(world: World) -> World:
    """The console starts again: what waits is taken along, but for that of a waiting client."""
    before, module = world.queue, sys.modules[type(world.queue).__module__]
    kept = [goal for goal in before.waiting if not goal.requester.waits]
    gone = [goal.number for goal in before.waiting if goal.requester.waits]
    gone += [goal.number for goal, _ in before.underway]
    # Numbers begin anew; this world goes on with them.
    queue = module.GoalQueue(submitted=before.submitted, ended=before.ended)
    typed = [entry for entry in world.typed if entry[0] not in [goal.number for goal in kept]]
    first = before.submitted + 1
    typed += [(first + place, first + place, YOU) for place in range(len(kept))]
    settled = (*world.settled, *(goal.number for goal in kept))
    world = world._replace(
        restarts_left=world.restarts_left - 1,
        lost=(*world.lost, *gone),
        typed=tuple(typed),
        settled=tuple(n for n in settled if n in [entry[0] for entry in typed]),
        has_left=True,
        queue=queue,
    )
    world = done(world, queue.restore([goal._replace(stop_count=world.stops) for goal in kept]))
    promise(not kept or bool(world.queue.hold_reason), "what a restart took along is held")
    return world


def moves(world: World) -> Iterator[tuple[str, Callable[[World], World]]]:
    """Yield all that can happen next, by its name."""
    queue, coming = world.queue, world.queue.coming
    if world.to_type and not (world.to_type[0][0] is SHELL and world.has_left):
        yield "type", type_list
    if coming is not None and not coming.is_handed_over:
        yield "begin", begin_sending
    if coming is not None and coming.is_handed_over:
        is_void = coming.goal.stop_count < world.stops or world.is_stopped
        is_shown = coming.goal.number in [sent.number for sent in world.robot]
        if (is_void or coming.waited) and not is_shown:  # A STOP may be known there first.
            yield "void", partial(answer, Code.HELD if coming.waited else Code.CANCELLED)
        if is_shown or not is_void:
            yield Code.ACCEPTED.value, partial(answer, Code.ACCEPTED)
        if not (is_void or is_shown):
            yield "taken", take
            for code in (Code.REFUSED, Code.TIMEOUT):
                yield code.value, partial(answer, code)
    for place, sent in enumerate(world.robot):
        if _runs(sent):
            for phase in (Phase.ARRIVED, Phase.ABORTED):
                yield f"{phase.name} {place}", partial(end_goal, place, phase)
    if world.stops_left:
        yield "stop", stop
    if world.stops_heard < world.stops:
        yield "hear stop", hear_stop
    elif world.is_stopped:
        yield "release", release
    if queue.hold_reason and world.stops_heard == world.stops:
        yield "continue", resume
    if queue.waiting:
        yield "skip", skip
    is_running = any(map(_runs, world.robot))
    if world.cancels_left and (is_running or coming):
        yield "cancel", cancel
    if world.leaves_left and not world.has_left:
        yield "leave", leave
    if world.ends_left and coming is not None:
        yield "end screen", end_screen
    if world.restarts_left and coming is None and not is_running and not world.is_stopped:
        yield "restart", restart
    if world.alarms_left or world.has_alarm:
        left = world.alarms_left - (not world.has_alarm)
        yield "alarm", lambda w: w._replace(has_alarm=not w.has_alarm, alarms_left=left)
    if world.others_left:
        other = Sent(Phase.MOVING, mine=False)
        yield (
            "another's goal",
            lambda w: w._replace(robot=(*w.robot, other), others_left=w.others_left - 1),
        )


def check(world: World) -> None:
    """Check the promises."""
    queue = world.queue
    waiting = [goal.number for goal in queue.waiting]
    coming = [queue.coming.goal.number] if queue.coming else []
    underway = [goal.number for goal, _ in queue.underway]
    everywhere = [*waiting, *coming, *underway, *world.settled, *world.lost]
    numbers = sorted(number for number, _, _ in world.typed)
    promise(sorted(everywhere) == numbers, "each goal is in one place, and none is forgotten")
    promise(len(underway) + len(coming) <= 1, "one goal is driven at a time")
    for number in world.sent:
        is_over = number in (*world.answered, *world.lost, *coming)
        promise(is_over, "each goal that is sent has an answer")
    for number, list_number, client in world.typed:
        reached = stage(queue, number)
        is_waiting = reached in (Stage.WAITING, Stage.HELD)
        if is_waiting:
            promise(list_number not in world.refused, "a refused list leaves nothing waiting")
            promise((reached is Stage.HELD) == bool(queue.hold_reason), "it is held or not")
        doubtful = [s for s in world.robot if s.number == number and s.phase is Phase.UNKNOWN]
        if client is SHELL and doubtful and number not in world.lost:
            promise(
                number in world.cancelling, "what has no answer is cancelled for one that waits"
            )
        if client is not SHELL or not world.has_left:
            continue
        promise(not is_waiting, "what a waiting client queued is gone when it is")
        if reached is Stage.ON_ITS_WAY:
            promise(queue.coming.is_abandoned, "what is on its way for it is cancelled")
            continue  # As soon as it is answered.
        sent = [s for s in world.robot if s.number == number and _runs(s)]
        if sent and number not in world.lost:
            promise(number in world.cancelling, "what runs for one that has left is cancelled")
    if world.is_stopped and queue.waiting:
        promise(queue.hold_reason == "STOP", "a STOP holds the queue")
    if world.must_ask:
        promise(bool(queue.hold_reason), "what waits for the operator is held")
    promise(bool(queue.waiting) or not queue.hold_reason, "nothing that is not there is held")
    is_free = not (queue.coming or any(map(_runs, world.robot)) or queue.hold_reason)
    promise(not (is_free and queue.waiting), "a queue that is not held goes on")


def _key(world: World) -> Any:
    """What makes a world differ from another one, hashable."""
    queue = world.queue
    goals = tuple((g.number, g.stop_count, g.requester) for g in queue.waiting)
    coming = queue.coming and queue.coming._replace(goal=queue.coming.goal.number)
    underway = tuple((goal.number, before) for goal, before in queue.underway)
    rest = queue._replace(waiting=goals, coming=coming, underway=underway)
    return world._replace(
        queue=rest,
        settled=tuple(sorted(world.settled)),
        answered=tuple(sorted(set(world.answered))),
        sent=tuple(sorted(set(world.sent))),
    )


def explore(world: World) -> Found:
    """Visit every state that can be reached, or until a promise is broken."""
    return breadth_first(world, moves, look, check, _key)


_ALL: dict[str, Any] = {"stops_left": 1, "leaves_left": 1, "cancels_left": 1}
SMALL: dict[str, Callable[..., World]] = {
    "a client's list": partial(begin, (SHELL, 2), stops_left=1, leaves_left=1),
    "two lists": partial(begin, (YOU, 2), (SHELL, 1), leaves_left=1, cancels_left=1),
    "a restart and the end of a screen": partial(
        begin, (YOU, 2), (SHELL, 1), ends_left=1, restarts_left=1
    ),
    "an alarm": partial(begin, (YOU, 2), alarms_left=1, stops_left=1),
    "another's goal": partial(begin, (YOU, 2), others_left=1, cancels_left=1),
}
LARGE: dict[str, Callable[..., World]] = {
    "a client's long list": partial(begin, (SHELL, 3), stops_left=1, leaves_left=1),
    "two lists and a STOP": partial(begin, (YOU, 2), (SHELL, 2), **_ALL),
    "two lists, two STOPs and an alarm": partial(
        begin, (SHELL, 2), (YOU, 1), stops_left=2, alarms_left=1, leaves_left=1
    ),
    "another's goal, a restart and a client that leaves": partial(
        begin, (SHELL, 2), (YOU, 1), others_left=1, restarts_left=1, leaves_left=1, cancels_left=1
    ),
}
WORLDS = {**SMALL, **LARGE}


def main() -> int:
    """Explore each world, and print what was found."""
    states = worst = 0
    for name, make in WORLDS.items():
        found = explore(make())
        states += found.states
        print(f"{name}: {found.states:,} states; {found.broken or 'all promises hold'}", flush=True)
        if found.broken:
            worst = 1
            print("   ", ", ".join(found.way))
    print(f"{states:,} states")
    return worst


if __name__ == "__main__":
    sys.exit(main())
