"""A robot that only shows what it is told, and a clock that stands."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

from archo_tui.alarms import AlarmBoard
from archo_tui.app import ArchoApp
from archo_tui.clock import Clock
from archo_tui.robot.state import Hosted, Outcome, Snapshot
from archo_tui.session import Options

NOW = 1000.0  # monotonic s of every snapshot
TIME = 1_700_000_000.0  # Unix time of every snapshot


class StandingClock(Clock):
    """Always NOW, unless moved."""

    def __init__(self) -> None:
        self.passed = 0.0

    def monotonic(self) -> float:
        return NOW + self.passed

    def now(self) -> float:
        return TIME + self.passed


class StubRobot:
    """Has every verb; none does anything."""

    def __init__(self, snapshot: Snapshot) -> None:
        self.snapshot = snapshot
        self._receiver: Any = None

    def subscribe(self, receiver: Any) -> None:
        self._receiver = receiver
        receiver(self.snapshot)

    def put(self, snapshot: Snapshot) -> None:
        """Something new was heard."""
        self.snapshot = snapshot
        self._receiver(snapshot)

    def __getattr__(self, verb: str) -> Any:
        async def refuse(*_: Any) -> Outcome:
            return Outcome(False, f"{verb}: the robot says why not")

        if verb == "note":
            return lambda *_: None

        return refuse


def stub_app(
    snapshot: Snapshot,
    clock: Clock | None = None,
    hosted: tuple[Hosted, ...] = (),
    keys: Mapping[str, str] | None = None,
) -> ArchoApp:
    """The app over a stub."""
    session: Any = SimpleNamespace(
        robot=StubRobot(snapshot),
        host=SimpleNamespace(states=lambda: hosted),
        options=Options(),
        engine="embedded",
        alarms=AlarmBoard(),
        alarmed=lambda changed: None,
    )
    app = ArchoApp(session, clock or StandingClock(), keys)
    app.animation_level = "none"
    return app
