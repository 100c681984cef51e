"""Run by .ci/run in an empty venv: an installed wheel carries all it needs."""

import asyncio
import sys

from archo_tui.screen.app import ArchoApp
from archo_tui.session.options import Options
from archo_tui.session.session import Session


async def main() -> int:
    """One goal, from the key to its arrival."""
    fast = ["-p", "feedback_period:=0.05", "-p", "time_scale:=75.0"]
    with Session(Options(ros_args=fast)) as session:
        app = ArchoApp(session.station)
        async with app.run_test(size=(120, 36)) as pilot:
            await pilot.press("g", "1", "2", "enter")
            for _ in range(500):
                await pilot.pause(0.02)
                goal = session.robot.snapshot.goal
                if goal is not None and goal.message == "Arrived at shelf 12":
                    print("arrived; parameters:", len(session.robot.snapshot.parameters))
                    return 0
    return 1


sys.exit(asyncio.run(main()))
