"""Every state of STOP in small worlds, breadth first.

A world has one or two servers of STOP, a peer console, an operator with two STOPs, a release and
two goals, and another client's goal. Whatever can happen next happens, in every order. Time and
turns are made finite: ages saturate beyond the thresholds of the rules, turns count by rank. Each
state is checked against the promises of docs/stop.md.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

from archo_tui.robot.state.readings import Motion
from archo_tui.robot.state.snapshot import Latch, StopAnswer
from archo_tui.robot.stop import machine
from tests.robot.exploring import Found, breadth_first, changed, promise

STEP = 0.5  # Seconds between two ticks of this world.
_OLDEST = -1.0  # Ages beyond it are the same to every rule.


class Server(NamedTuple):
    """A node that serves STOP and its release."""

    alive: bool = True
    lives: int = 0  # How often it was restarted.
    stopped: bool = False
    is_suspended: bool = False  # It has left the graph, and comes back as it was.
    waiting: tuple[int, ...] = ()  # The requests that it has not handled, by their numbers.


class Request(NamedTuple):
    """A call of STOP, or the release."""

    number: int
    turn: int
    is_stop: bool
    asked: int  # The number of servers that it was sent to.
    to: Any = frozenset()  # The nodes that it was sent to, as the console knows them.
    answers: str = ""  # `y` or `n` of each server that handled it.
    is_over: bool = False  # Its time is over, or it was delivered.


class Goal(NamedTuple):
    """A goal of this console."""

    stops: int  # STOPs that had been read when it was typed.
    turn: int = 0  # 0: not sent yet.
    phase: str = "typed"  # typed, sent, runs (unknown here), moving (known here), over
    is_asked: bool = False  # A cancel was requested.


class World(NamedTuple):
    """All there is, with the console's machine in it."""

    servers: tuple[Server, ...]
    stop: Any  # machine.Stop
    reports: str = ""  # Nothing; "motion"; "stop": its motion, and whether it is stopped.
    stops_left: int = 1
    releases_left: int = 0
    restarts_left: int = 0
    pauses_left: int = 0  # How often a server may be suspended.
    peer_left: tuple[str, ...] = ()
    goals_left: int = 0
    sends_left: int = 0  # Calls that the machine may make by itself; later ones are left out.
    peer_says: tuple[str, ...] = ()  # Reports of the peer on their way.
    requests: tuple[Request, ...] = ()
    goals: tuple[Goal, ...] = ()
    stops_read: int = 0
    other_runs: bool = True  # Another client's goal, tracked since turn 1.
    other_is_asked: bool = False
    is_polled: bool = True  # The console knows which nodes there are.
    passed: int = 0  # Ticks since the last STOP was read.
    outsiders_left: int = 0  # Releases that no console makes, and only the robot's reports tell.
    is_reported: bool = True  # The robot has reported its motion since.
    is_past: bool = False  # The STOP was given up or released: nothing follows it any more.
    publications_left: int = 0  # Messages that are typed to be published without end.
    publishes: int | None = None  # STOPs that had been read when what is published was typed.
    is_last: bool = False  # A STOP is the last that the operator asked for.


def begin(servers: int = 1, **limits: Any) -> World:
    """Return a world in which nothing has happened; `machine` may be a broken one by then."""
    return World(tuple(Server() for _ in range(servers)), machine.Stop(), **limits)


# What can be seen of a world.


def served(world: World) -> Any:
    return frozenset(
        (f"/{'ab'[place]}", frozenset((bytes([server.lives]),)))
        for place, server in enumerate(world.servers)
        if server.alive
    )


def next_turn(world: World) -> int:
    stop = world.stop
    turns = [2, stop.first_turn, stop.answered_turn, stop.last_turn, stop.peer_turn]
    turns += [stop.past_turn, stop.pressed_turn]
    turns += [pair[0] for pair in (stop.obeyed, stop.cancels) if pair]
    turns += [request.turn for request in world.requests] + [goal.turn for goal in world.goals]
    return int(max(turns)) + 1


def may_move(world: World) -> bool:
    """True unless every server that is there is stopped."""
    here = [server for server in world.servers if server.alive or server.is_suspended]
    return not here or not all(server.stopped for server in here)


def runs(world: World) -> bool:
    return world.other_runs or any(goal.phase in ("runs", "moving") for goal in world.goals)


# What happens.


def _request(world: World, *, is_stop: bool) -> World:
    number = max((request.number for request in world.requests), default=0) + 1
    alive = [server.alive for server in world.servers]
    request = Request(number, next_turn(world), is_stop, sum(alive), served(world))
    servers = tuple(
        server._replace(waiting=(*server.waiting, number)) if server.alive else server
        for server in world.servers
    )
    return world._replace(servers=servers, requests=(*world.requests, request))


def _call(world: World, *, is_pressed: bool = True) -> World:
    """Call STOP as `StopSender` does."""
    turn = next_turn(world)
    world = world._replace(stop=world.stop.calling(turn, 0.0, is_pressed=is_pressed))
    if not served(world):
        result = machine.Result(StopAnswer.NOT_SENT)
        return _answer(world, result, turn, served(world))
    # `calling` and `leaving` are two turns; the answer belongs to the first.
    stop = world.stop.leaving(turn + 1, served(world))
    world = _request(world._replace(stop=stop), is_stop=True)
    *earlier, last = world.requests
    return world._replace(requests=(*earlier, last._replace(turn=turn)))


def _answer(world: World, result: Any, turn: int, asked: Any, *, is_late: bool = False) -> World:
    before = world.stop
    stop = before.answered_by(
        result, turn, 0.0, next_turn(world), asked, served(world), (), is_late=is_late
    )
    if result.is_yes and before.open is not None and turn < before.first_turn:
        promise(stop.open is not None, "a yes to an earlier STOP confirms no later one")
    is_back = result.is_yes and not stop.is_given_up  # A late yes to one that was given up.
    return world._replace(stop=stop, is_past=world.is_past and not is_back)


def read_stop(world: World) -> World:
    world = world._replace(
        stops_left=world.stops_left - 1,
        stops_read=world.stops_read + 1,
        passed=0,
        is_past=False,
        is_last=True,
    )
    return _call(world)


def handle(place: int, number: int, answer: str, world: World) -> World:
    """A server handles a waiting request; of several any one."""
    server, request = world.servers[place], _numbered(world, number)
    stopped = request.is_stop if answer == "y" else server.stopped
    waiting = tuple(n for n in server.waiting if n != number)
    world = _with_server(world, place, stopped=stopped, waiting=waiting)
    return _with_request(world, number, answers="".join(sorted(request.answers + answer)))


def _numbered(world: World, number: int) -> Request:
    return next(request for request in world.requests if request.number == number)


def _with_request(world: World, number: int, **changes: Any) -> World:
    place = world.requests.index(_numbered(world, number))
    return world._replace(requests=changed(world.requests, place, **changes))


def deliver(number: int, world: World) -> World:
    """The answers of all servers to a request reach the console."""
    request = _numbered(world, number)
    requests = tuple(r for r in world.requests if r.number != number)
    world = world._replace(requests=requests)
    if request.is_stop:
        answer = StopAnswer.REFUSED if "n" in request.answers else StopAnswer.AWAITED
        result = machine.Result(answer)
        return _answer(world, result, request.turn, request.to, is_late=request.is_over)
    stop = world.stop
    if "n" not in request.answers:
        before, stop = stop, stop.release_accepted(request.turn, 0.0, next_turn(world))
        if before.latch is not Latch.NONE and request.turn <= before.peer_turn:
            promise(stop.latch is not Latch.NONE, "a release from before a STOP does not undo it")
    world = world._replace(stop=stop)
    return _call(world) if stop.must_follow(request.turn) else world


def time_out(number: int, world: World) -> World:
    request = _numbered(world, number)
    world = _with_request(world, number, is_over=True)
    if not request.is_stop:
        return world
    return _answer(world, machine.Result(StopAnswer.NONE), request.turn, request.to)


def release(world: World) -> World:
    world = world._replace(releases_left=world.releases_left - 1, is_last=False)
    return _request(world, is_stop=False)


def give_up(world: World) -> World:
    return world._replace(stop=world.stop.given_up(), is_past=True, is_last=False)


def leave(place: int, world: World) -> World:
    """A server ends; what it had not handled is lost."""
    world = _with_server(world, place, alive=False, stopped=False, waiting=())
    return world._replace(restarts_left=world.restarts_left - 1, is_polled=False)


def come_back(place: int, world: World) -> World:
    world = _with_server(world, place, alive=True, lives=world.servers[place].lives + 1)
    return world._replace(is_polled=False)


def suspend(place: int, world: World) -> World:
    world = _with_server(world, place, alive=False, is_suspended=True)
    return world._replace(pauses_left=world.pauses_left - 1, is_polled=False)


def resume(place: int, world: World) -> World:
    return _with_server(world, place, alive=True, is_suspended=False)._replace(is_polled=False)


def _with_server(world: World, place: int, **changes: Any) -> World:
    return world._replace(servers=changed(world.servers, place, **changes))


def poll(world: World) -> World:
    return world._replace(stop=world.stop.served_by(served(world), (), 0.0), is_polled=True)


def peer_does(what: str, world: World) -> World:
    """The peer console stops or releases the robot; its report comes later."""
    servers = tuple(
        server._replace(stopped=what == "stop") if server.alive else server
        for server in world.servers
    )
    left = tuple(other for other in world.peer_left if other != what)
    return world._replace(
        servers=servers,
        peer_left=left,
        peer_says=(*world.peer_says, what),
        is_reported=world.reports != "stop",
        is_last=world.is_last and what == "stop",
    )


def hear_peer(world: World) -> World:
    what, *rest = world.peer_says
    stop, stops_read = world.stop, world.stops_read
    if what == "stop":
        stop = stop.stopped_elsewhere("peer", next_turn(world), 0.0, served(world), ())
        stops_read += 1
    else:
        stop = stop.released_elsewhere("peer", next_turn(world), 0.0)
    passed = 0 if what == "stop" else world.passed
    return world._replace(stop=stop, peer_says=tuple(rest), stops_read=stops_read, passed=passed)


def report(world: World) -> World:
    """The robot reports its motion."""
    moves = runs(world) and may_move(world)
    stopped = not may_move(world) if world.reports == "stop" else None
    motion = Motion(moving=moves, stopped=stopped, received=0.0)
    before = world.stop
    stop = before.moved(motion, 0.0, served(world), ())
    if before.says_stopped and stopped is False:
        promise(stop.latch is not Latch.HELD, "the robot's own report ends a STOP")
    return world._replace(stop=stop, is_reported=True)


def outside(world: World) -> World:
    servers = tuple(server._replace(stopped=False) for server in world.servers)
    left = world.outsiders_left - 1
    return world._replace(servers=servers, outsiders_left=left, is_reported=False, is_last=False)


def type_goal(world: World) -> World:
    goal = Goal(world.stops_read)
    return world._replace(goals=(*world.goals, goal), goals_left=world.goals_left - 1)


def publish(world: World) -> World:
    return world._replace(publishes=world.stops_read, publications_left=world.publications_left - 1)


def _with_goal(world: World, place: int, **changes: Any) -> World:
    return world._replace(goals=changed(world.goals, place, **changes))


def send_goal(place: int, world: World) -> World:
    goal = world.goals[place]
    if goal.stops < world.stops_read or not world.stop.may_start:
        return _with_goal(world, place, phase="over")
    return _with_goal(world, place, phase="sent", turn=next_turn(world))


def take_goal(place: int, world: World) -> World:
    """The robot accepts a goal; a stopped one refuses it."""
    is_stopped = any(server.alive and server.stopped for server in world.servers)
    return _with_goal(world, place, phase="over" if is_stopped else "runs")


def hear_goal(place: int, world: World) -> World:
    """The console hears that its goal was accepted."""
    goal = world.goals[place]
    is_void = goal.stops < world.stops_read
    world = _with_goal(world, place, phase="moving", is_asked=goal.is_asked or is_void)
    return world._replace(stop=world.stop.goal_accepted(goal.turn, 0.0))


def end_goal(place: int, world: World) -> World:
    return _with_goal(world, place, phase="over")


def pass_time(world: World) -> World:
    """Half a second passes; then the machine ticks, and what it asks for is done."""
    world = world._replace(stop=_older(world.stop), passed=min(world.passed + 1, 1))
    facts = machine.Facts(runs(world), True, bool(served(world)))
    stop, todo = world.stop.tick(0.0, facts)
    world = world._replace(stop=stop)
    if world.publishes is not None:
        is_void = world.publishes < world.stops_read
        if not stop.lets_publish(is_void=is_void):
            world = world._replace(publishes=None)
    for what, turn in todo:
        if what is machine.StopEffect.SEND:
            promise(stop.open is not None, "only an open STOP is sent again")
            promise(not stop.awaited, "never two calls at once")
            if world.sends_left:
                world = _call(world._replace(sends_left=world.sends_left - 1), is_pressed=False)
        elif what is machine.StopEffect.CANCEL_OWN:
            for place, goal in enumerate(world.goals):
                if goal.phase == "moving" and goal.turn < turn:
                    world = _with_goal(world, place, is_asked=True)
        else:
            promise(not world.is_past, "what follows a STOP ends when it is given up")
            world = world._replace(other_is_asked=True)
    return world


# Finite time and turns.


def _older(stop: Any) -> Any:
    def age(then: float | None) -> float | None:
        if then is None or then == float("-inf"):
            return then
        return max(round(then - STEP, 1), _OLDEST)

    times = ("answered", "servers_changed", "due", "moves_since", "undone")
    return stop._replace(
        open=stop.open and stop.open._replace(asked=age(stop.open.asked)),
        obeyed=stop.obeyed and (stop.obeyed[0], age(stop.obeyed[1])),
        cancels=stop.cancels and (stop.cancels[0], age(stop.cancels[1])),
        **{name: age(getattr(stop, name)) for name in times},
    )


def normal(world: World) -> World:
    """The world with turns by rank, and without what decides nothing any more."""
    stop = world.stop._replace(held=0.0, released=None, seen_stopped=float("-inf"))
    if stop.open is None:
        stop = stop._replace(first_turn=0, answered_turn=0, answered=0.0, pressed_turn=0)
    # Only whether the goals of others were cancelled for the last press counts.
    is_done = stop.open is not None and stop.all_cancelled == stop.pressed_turn
    stop = stop._replace(pressed_turn=1, all_cancelled=int(is_done))
    if stop.state.name == "NONE":
        stop = stop._replace(
            holders=frozenset(), servers_changed=float("-inf"), seen_servers=frozenset()
        )
    if stop.state.name != "HELD":
        stop = stop._replace(peer="")
    handled = {number for server in world.servers for number in server.waiting}
    requests = [
        request
        for request in sorted(world.requests, key=lambda request: request.number)
        # One that a server lost is never answered.
        if not request.is_over or request.number in handled or len(request.answers) == request.asked
    ]
    # Only its order among those that can still be answered makes a turn differ from another.
    turns = {request.turn for request in requests} | {goal.turn for goal in world.goals}
    order = sorted((turns | {stop.first_turn}) - {0})

    def rank(turn: int) -> int:
        return 0 if turn == 0 else 2 * bisect_left(order, turn) + (turn in order) + 2

    ranked = ("first_turn", "answered_turn", "last_turn", "peer_turn", "past_turn")
    stop = stop._replace(
        **{name: rank(getattr(stop, name)) for name in ranked},
        others_before=min(stop.others_before, 1),
        obeyed=stop.obeyed and (rank(stop.obeyed[0]), 0.0),  # Nothing here asks for its time.
        cancels=stop.cancels and (rank(stop.cancels[0]), max(stop.cancels[1], 0.0)),
    )
    renamed = {request.number: place for place, request in enumerate(requests, 1)}
    servers = tuple(
        server._replace(waiting=tuple(sorted(renamed[n] for n in server.waiting if n in renamed)))
        for server in world.servers
    )
    return world._replace(
        stop=stop,
        servers=servers,
        requests=tuple(r._replace(number=renamed[r.number], turn=rank(r.turn)) for r in requests),
        goals=tuple(goal._replace(turn=rank(goal.turn)) for goal in world.goals),
    )


# What can happen next.


def moves(world: World) -> Iterator[tuple[str, Callable[[World], World]]]:
    """Yield all that can happen next, by its name."""
    if not world.peer_says:  # Its reports take less than half a second.
        yield "time", pass_time
    if world.stops_left:
        yield "stop", read_stop
    if world.stop.open is not None:
        yield "give up", give_up
    if world.releases_left and world.stops_read:
        yield "release", release
    for place, server in enumerate(world.servers):
        name = "ab"[place]
        for number in () if server.is_suspended else server.waiting:
            yield f"{name} yes {number}", partial(handle, place, number, "y")
            if next(r for r in world.requests if r.number == number).is_stop:
                yield f"{name} no {number}", partial(handle, place, number, "n")
        if server.alive and world.restarts_left and not world.peer_says:
            yield f"{name} leaves", partial(leave, place)
        # Of one that is suspended before no console knows anything.
        if server.alive and world.pauses_left and world.stops_read:
            yield f"{name} is suspended", partial(suspend, place)
        if server.is_suspended:
            yield f"{name} is resumed", partial(resume, place)
        elif not server.alive:
            yield f"{name} returns", partial(come_back, place)
    for request in world.requests:
        if len(request.answers) == request.asked:
            yield f"deliver {request.number}", partial(deliver, request.number)
        elif not request.is_over:
            yield f"time out {request.number}", partial(time_out, request.number)
    if not world.is_polled:
        yield "poll", poll
    if world.peer_left and served(world):
        yield f"peer {world.peer_left[0]}", partial(peer_does, world.peer_left[0])
    if world.peer_says:
        yield "hear peer", hear_peer
    if world.reports and len(served(world)) == 1:
        yield "report", report
    if world.outsiders_left and served(world):
        yield "somebody releases", outside
    if world.goals_left:
        yield "type goal", type_goal
    if world.publications_left and world.stop.lets_publish(is_void=False):
        yield "publish", publish
    for place, goal in enumerate(world.goals):
        then = {
            "typed": ("send", send_goal),
            "sent": ("take", take_goal),
            "runs": ("hear", hear_goal),
            "moving": ("end", end_goal),
        }.get(goal.phase)
        if then is not None:
            yield f"{then[0]} goal {place}", partial(then[1], place)


# What must hold.


def check(world: World) -> None:
    """Check the promises of docs/stop.md."""
    stop = world.stop
    is_quiet = not (world.requests or world.peer_says) and world.is_polled and world.is_reported
    # A robot that reports its stop is shown as it reports.
    is_shown = stop.says_stopped if stop.reports else True
    if stop.latch is Latch.HELD and stop.open is None and is_quiet and is_shown:
        promise(not may_move(world), "a robot that may move is not shown as STOPPED")
    if stop.may_start:
        is_over = stop.open is None and stop.latch is Latch.NONE
        promise(is_over, "no goal, program or console starts behind a STOP")
        promise(not world.is_last, "no goal, program or console starts behind a STOP")
    awaited = [r for r in world.requests if r.is_stop and not r.is_over]
    promise(stop.awaited == len(awaited), "each call is awaited until it is answered or over")
    for goal in world.goals:
        is_old = goal.stops < world.stops_read and world.passed >= 1
        if goal.phase == "moving" and is_old:
            promise(goal.is_asked, "a goal from before a STOP that runs behind it is cancelled")
    if world.publishes is not None and world.passed >= 1:
        is_behind = world.publishes < world.stops_read
        promise(not is_behind, "nothing is published behind a STOP that came after it")
    if stop.open is not None:
        open_for = -stop.open.asked
        if open_for >= 1.0 and world.other_runs and world.passed:
            promise(world.other_is_asked, "goals of others are cancelled behind an open STOP")
        promise(_is_sent_again(world), "an open STOP is sent again")
    promise((stop.state.name in ("NONE", "HELD")) == (not stop.doubt), "a doubt has its reason")


def _is_sent_again(world: World) -> bool:
    """Return True if within some ticks the open STOP is sent, if it can be."""
    stop = world.stop
    if stop.awaited or not served(world):
        return True
    facts = machine.Facts(True, True, True)
    for _ in range(4):
        stop = _older(stop)
        stop, todo = stop.tick(0.0, facts)
        if any(what is machine.StopEffect.SEND for what, _ in todo):
            return True
    return False


def explore(world: World) -> Found:
    """Visit every state that can be reached, or until a promise is broken."""
    return breadth_first(normal(world), moves, normal, check, lambda world: world)


BOTH = ("stop", "release")
# By day, without what is left of calls that the machine makes by itself; seconds in all.
SMALL: dict[str, dict[str, Any]] = {
    "a release": {"releases_left": 1},
    "a goal": {"goals_left": 1},
    "a message that is published without end": {"publications_left": 1, "releases_left": 1},
    "a restart": {"restarts_left": 1, "sends_left": 1},
    "a peer": {"peer_left": BOTH},
    "a peer's STOP and a restart": {"peer_left": ("stop",), "restarts_left": 1},
    "a restart, reported": {"reports": "stop", "restarts_left": 1},
    "somebody who releases, reported": {"reports": "stop", "outsiders_left": 1},
}
# Further worlds, for the night: minutes in all. What is reported is a robot's stop or its motion.
LARGE: dict[str, dict[str, Any]] = {
    "a goal and a release": {"goals_left": 1, "releases_left": 1},
    "two goals": {"goals_left": 2},
    "two STOPs and a release": {"stops_left": 2, "releases_left": 1},
    "a restart and a release": {"restarts_left": 1, "releases_left": 1, "sends_left": 1},
    "a suspended server and a release": {"pauses_left": 1, "releases_left": 1},
    "two servers and a release": {"servers": 2, "releases_left": 1, "sends_left": 1},
    "two servers and a restart": {"servers": 2, "restarts_left": 1, "sends_left": 1},
    "two servers, of which one is suspended": {"servers": 2, "pauses_left": 1, "sends_left": 1},
    "two servers and a restart, motion": {"servers": 2, "reports": "motion", "restarts_left": 1},
    "two servers and a restart, reported": {"servers": 2, "reports": "stop", "restarts_left": 1},
    "a peer and a restart": {"peer_left": BOTH, "restarts_left": 1},
    "a peer and a release": {"peer_left": BOTH, "releases_left": 1},
    "a peer, reported": {"reports": "stop", "peer_left": BOTH, "sends_left": 1},
    "a peer and a restart, reported": {"reports": "stop", "peer_left": BOTH, "restarts_left": 1},
    "a peer's release and ours, reported": {
        **{"reports": "stop", "peer_left": ("release",), "releases_left": 1}
    },
    "a release, motion": {"reports": "motion", "releases_left": 1, "sends_left": 1},
    "a restart, motion": {"reports": "motion", "restarts_left": 1, "sends_left": 1},
    "a release, reported": {"reports": "stop", "releases_left": 1, "sends_left": 1},
    "two STOPs and a restart, reported": {
        **{"reports": "stop", "stops_left": 2, "restarts_left": 1}
    },
    "somebody who releases and a restart, reported": {
        **{"reports": "stop", "outsiders_left": 1, "restarts_left": 1}
    },
}
WORLDS = {**SMALL, **LARGE}
