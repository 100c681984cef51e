"""A session that runs files of the user's own, and what is seen of them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from archo_tui.robot.state.snapshot import Hosted
from archo_tui.session.options import Options
from archo_tui.session.session import Session
from tests.support import chosen, clock


def written(name: str | Path, text: str) -> Path:
    file = Path(name)
    file.write_text(text)
    return file


@contextmanager
def running(*files: Path, only: bool = True, **options: Any) -> Iterator[Session]:
    """A session that runs these files, and nothing of the robot's own unless `only` is false."""
    given = {"domain_id": chosen.next_domain(), "node_files": files, "only": only, **options}
    with Session(Options(chosen.ENGINE, **given), clock.current) as session:
        yield session


def states(session: Session) -> dict[str, Hosted]:
    return {hosted.name: hosted for hosted in session.host.states()}


def texts(session: Session) -> list[str]:
    return [event.text for event in session.robot.snapshot.events]
