"""The subcommand `robot`, which writes a robot file for the robot that is on the ROS 2 graph."""

from __future__ import annotations

import os.path
from argparse import Namespace
from pathlib import Path

from archo_tui.cli.output import FAILED, complain
from archo_tui.errors import ArchoError
from archo_tui.safe_text import safe

TYPE_CHECKING = False  # Importing typing takes longer than a short command.
if TYPE_CHECKING:
    from archo_tui.station.station import Station

_DISCOVERY = 2.0  # Seconds in which further nodes are discovered after the first one.
_POLLING_PERIOD = 0.05  # Seconds.


def describe_robot(options: Namespace) -> int:
    """Print a robot file for the robot on the ROS 2 graph, or write it to a new file.

    It listens for some seconds, and sends nothing to the robot.
    """
    import asyncio

    from archo_tui.parameters.save_load import write_atomically
    from archo_tui.robot_file.propose import SeveralRobots
    from archo_tui.session import Session
    from archo_tui.session_options import Options

    if options.engine != "ros2":
        raise ArchoError("robot looks at a ROS 2 graph, which the embedded engine has not")
    path = Path(options.out) if options.out else None
    if path is not None and os.path.lexists(path):
        raise ArchoError(f"{path} already exists: name another file")
    try:
        with Session(
            Options(engine="ros2", attach=True, watch=True, namespace=options.namespace)
        ) as session:
            text = asyncio.run(_wait_for_robot_file(session.station))
    except SeveralRobots as error:
        raise ArchoError(f"{error}: name one with --namespace") from None
    except TimeoutError:
        complain("the console's own node does not answer")
        return FAILED
    if not text:
        return FAILED
    if path is None:
        print("\n".join(map(safe, text.splitlines())))
    else:
        write_atomically(path, text)
        print(safe(f"Written to {path}. Check every line: nothing in it was tried."))
    return 0


async def _wait_for_robot_file(station: Station) -> str:
    """Wait for a robot, listen to it, and return a robot file for it; "" if none is found."""
    import asyncio

    from archo_tui.text.state import elsewhere_text
    from archo_tui.verbs.topics import robot_file_text
    from archo_tui.verbs.verb import ROBOT_TIMEOUT

    while not station.robot.snapshot.nodes and station.age < ROBOT_TIMEOUT:
        await asyncio.sleep(_POLLING_PERIOD)
    snapshot = station.robot.snapshot
    if not snapshot.nodes:
        others = elsewhere_text(snapshot)
        where = f"in namespace {snapshot.namespace}: {others}" if others else station.unseen
        complain(f"no robot is {where}")
        return ""
    await asyncio.sleep(_DISCOVERY)
    return await robot_file_text(station)
