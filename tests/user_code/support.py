"""A session that runs files of the user's own, and what is seen of them."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from archo_tui.robot.state.snapshot import Hosted, Life
from archo_tui.session.options import Options
from archo_tui.session.session import Session
from tests.support import chosen, clock
from tests.support.waiting import wait_until


def written(name: str | Path, text: str) -> Path:
    file = Path(name)
    file.write_text(text)
    return file


def spinning(name: str, text: str) -> Path:
    """A program that makes a node of its name, does what the text says, and spins the node."""
    head = "import os, subprocess, threading, time\nfrom pathlib import Path\nimport rclpy\n"
    made = f'rclpy.init()\nnode = rclpy.create_node("{name}")\n'
    return written(f"{name}.py", f"{head}{made}{text}\nrclpy.spin(node)\n")


@contextmanager
def running(*files: Path, only: bool = True, **options: Any) -> Iterator[Session]:
    """A session that runs these files, and nothing of the robot's own unless `only` is false."""
    given = {"domain_id": chosen.next_domain(), "node_files": files, "only": only, **options}
    with Session(Options(chosen.ENGINE, **given), clock.current) as session:
        yield session


def states(session: Session) -> dict[str, Hosted]:
    return {hosted.name: hosted for hosted in session.host.states()}


def life(session: Session, name: str = "/talker") -> Life:
    return states(session)[name].life


def texts(session: Session) -> list[str]:
    return [event.text for event in session.robot.snapshot.events]


def is_told(session: Session, text: str) -> bool:
    """Whether an event begins with that."""
    return any(event.startswith(text) for event in texts(session))


def stop(session: Session) -> None:
    """Stop the robot once it can be stopped."""
    wait_until(lambda: "emergency_stop" in session.robot.snapshot.offered)
    assert asyncio.run(session.robot.emergency_stop()).ok


def release(session: Session) -> None:
    assert asyncio.run(session.robot.release_emergency_stop()).ok
