"""A Robot beside nodes of a test's own; no screen."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any

from rclpy.node import Node

from archo_tui.robot.robot import Robot
from archo_tui.session.options import Options
from archo_tui.session.session import Session
from tests.support import chosen, clock
from tests.support.quiet import until


def making(made: list[Any], kind: Any, *given: Any, **fixed: Any) -> Callable[..., Node]:
    """Return a maker of a node of that class, which puts what it makes into `made`."""

    def make(**options: Any) -> Node:
        made.append(kind(*given, **fixed, **options))
        node: Node = made[-1]
        return node

    return make


def hearing(
    heard: list[Any], kind: Any, topic: str = "words", *, read: Callable[[Any], Any] = lambda m: m
) -> Callable[..., Node]:
    """Return a maker of a node that puts what it reads of each message of a topic into `heard`."""

    def make(**options: Any) -> Node:
        node = Node("hearing", **options)
        node.create_subscription(kind, topic, lambda message: heard.append(read(message)), 10)
        return node

    return make


@asynccontextmanager
async def robot(
    *makers: Callable[..., Node], nodes: int | None = None, offers: str = "", **options: Any
) -> AsyncIterator[Robot]:
    """It has seen all of the nodes (or so many), and what they offer; `options` as of a session."""
    given = {"domain_id": chosen.next_domain(), **options}
    with Session(
        Options(engine=chosen.ENGINE, node_makers=makers, **given), clock.current
    ) as session:
        wanted = len(makers) if nodes is None else nodes
        await until(lambda: len(session.robot.snapshot.nodes) == wanted)
        await until(lambda: session.robot.snapshot.offered >= {*offers.split()})
        yield session.robot


def texts(robot: Robot) -> list[str]:
    """Return the texts of its events, the newest last."""
    return [event.text for event in robot.snapshot.events]
