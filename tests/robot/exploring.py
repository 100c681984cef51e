"""Small worlds, explored breadth first to the last state; and machines broken on purpose.

`python -m tests.robot.exploring` explores those of STOP, a goal and the queue of goals, and prints
of a broken promise the shortest way to it.
"""

from __future__ import annotations

import contextlib
import random
import sys
import time
from collections import deque
from collections.abc import Callable, Hashable, Iterator
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple, TypeVar

from tests.mutants import mutants

World = TypeVar("World")
MOST = 300_000  # States; more than any of the worlds has.


class Broken(AssertionError):
    """A promise that does not hold."""


def promise(holds: bool, what: str) -> None:
    if not holds:
        raise Broken(what)


class Found(NamedTuple):
    """What an exploration found."""

    states: int
    broken: str  # The promise that does not hold, or "".
    way: tuple[str, ...]  # The shortest way to it.


def changed(items: tuple[Any, ...], place: int, **changes: Any) -> tuple[Any, ...]:
    """Return named tuples of which the one at a place is changed."""
    return (*items[:place], items[place]._replace(**changes), *items[place + 1 :])


def breadth_first(
    first: World,
    moves: Callable[[World], Iterator[tuple[str, Callable[[World], World]]]],
    settle: Callable[[World], World],
    check: Callable[[World], None],
    key: Callable[[World], Hashable],
) -> Found:
    """Visit every state that can be reached, or until a promise is broken.

    A state is known by the hash of its key: so many worlds would not fit into the memory.
    """
    start = hash(key(first))
    came: dict[int, tuple[int, str]] = {start: (start, "")}
    frontier = deque([first])
    while frontier:
        here = frontier.popleft()
        where = hash(key(here))
        for name, happen in moves(here):
            try:
                there = settle(happen(here))
                reached = hash(key(there))
                if reached in came:
                    continue
                check(there)
            except Broken as error:
                return Found(len(came), str(error), (*_way(came, where), name))
            if len(came) >= MOST:
                return Found(len(came), "a small world has an end", (*_way(came, where), name))
            came[reached] = where, name
            frontier.append(there)
    return Found(len(came), "", ())


def _way(came: dict[int, tuple[int, str]], world: int) -> tuple[str, ...]:
    way: list[str] = []
    while came[world][1]:
        world, name = came[world]
        way.append(name)
    return tuple(reversed(way))


def planted(machine: ModuleType, count: int) -> Iterator[tuple[str, ModuleType]]:
    """Yield machines with a fault each, drawn at random, and what the fault is."""
    source = Path(str(machine.__file__)).read_bytes()
    for mutant in random.Random(1).sample(mutants(source), count):
        name = f"broken_{machine.__name__.rpartition('.')[2]}"
        spec = spec_from_loader(name, None)
        assert spec is not None
        module = sys.modules[name] = module_from_spec(spec)
        with contextlib.suppress(Exception):  # One that cannot even be imported is found.
            exec(compile(mutant.planted_in(source), name, "exec"), module.__dict__)
            yield f"{mutant.line}: {mutant.before} -> {mutant.after}", module


def main() -> int:
    """Explore each world, and print what was found."""
    from archo_tui.ros import engine

    engine.activate("embedded")  # For the interfaces.
    from tests.robot import explore, explore_goal, explore_queue

    worst = 0
    for room, exploring in (("STOP", explore), ("queue", explore_queue), ("goal", explore_goal)):
        states = 0
        for name, world in exploring.WORLDS.items():
            began = time.process_time()
            found = exploring.explore(exploring.begin(**world))
            states += found.states
            took = time.process_time() - began
            said = found.broken or "all promises hold"
            print(f"{room}: {name}: {found.states:,} states in {took:.0f} s; {said}", flush=True)
            if found.broken:
                worst = 1
                print(f"    {', '.join(map(repr, found.way))}")
        print(f"{room}: {states:,} states")
    return worst


if __name__ == "__main__":
    sys.exit(main())
