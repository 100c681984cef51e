"""The subcommands for the ROS 2 graph: `look` for nodes, and `robot`, which writes a robot file."""

from __future__ import annotations

import os
import sys
import time
from argparse import Namespace
from collections.abc import Mapping, Sequence

from archo_tui.base.errors import ArchoError, in_one_line
from archo_tui.base.safe_text import safe
from archo_tui.client.protocol import FAILED
from archo_tui.client.shell import complain

TYPE_CHECKING = False  # Importing typing takes longer than a short command.
if TYPE_CHECKING:
    from archo_tui.station.station import Station

_DOMAINS = range(21)  # ROS_DOMAIN_ID 0 to 20: those that people choose by hand.
_DISCOVERY = 3.0  # Seconds in which nodes answer.
_NAMED = 4  # Nodes of a domain that are named.


def look(_options: Namespace) -> int:
    """Print the nodes in the ROS 2 domains, and end the process; its code is FAILED for none."""
    import importlib.util

    if importlib.util.find_spec("rclpy") is None:
        raise ArchoError("look needs ROS 2: docs/ros2.md says how to install it")
    errors, null = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 2)  # DDS complains there of what is no fault.
    try:
        found = _find_nodes()
    except Exception as error:  # Whatever ROS raises.
        os.dup2(errors, 2)
        raise ArchoError(f"the domains could not be looked at: {in_one_line(error)}") from None
    for line in domains_text(found).splitlines():
        print(safe(line))
    sys.stdout.flush()
    os._exit(0 if found else FAILED)  # To leave the domains one after the other takes seconds.


def _find_nodes() -> Mapping[int, Sequence[str]]:
    """Return the nodes in each domain that has any; hidden ones are left out."""
    from archo_tui.ros import engine

    engine.activate("ros2")
    import rclpy
    from rclpy.context import Context
    from rclpy.signals import SignalHandlerOptions

    nodes = {}
    for domain in _DOMAINS:
        context = Context()
        rclpy.init(
            context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO
        )
        nodes[domain] = rclpy.create_node(
            "_archo_tui_scan",
            context=context,
            start_parameter_services=False,
            enable_rosout=False,
        )
    time.sleep(_DISCOVERY)
    found = {}
    for domain, node in nodes.items():
        pairs = node.get_node_names_and_namespaces()
        names = sorted(f"{namespace.rstrip('/')}/{name}" for name, namespace in pairs)
        shown = [name for name in names if not name.rpartition("/")[2].startswith("_")]
        if shown:
            found[domain] = shown
    return found


def domains_text(found: Mapping[int, Sequence[str]]) -> str:
    """Return a line for each domain with nodes, and how to operate the robot there."""
    if not found:
        return (
            f"no node in the domains {_DOMAINS[0]} to {_DOMAINS[-1]}, as far as this computer's "
            "discovery reaches (ROS_AUTOMATIC_DISCOVERY_RANGE)"
        )
    return "\n".join(
        f"domain {domain}: {_nodes(nodes)}: start with ROS_DOMAIN_ID={domain}"
        for domain, nodes in sorted(found.items())
    )


def _nodes(nodes: Sequence[str]) -> str:
    named = ", ".join(nodes[:_NAMED])
    return f"{named} and {len(nodes) - _NAMED} more" if len(nodes) > _NAMED else named


_SETTLING = 2.0  # Seconds in which further nodes are discovered after the first one.
_POLLING_PERIOD = 0.05  # Seconds.


def describe_robot(options: Namespace) -> int:
    """Print a robot file for the robot on the ROS 2 graph, or write it to a new file.

    It listens for some seconds, and sends nothing to the robot.
    """
    import asyncio

    from archo_tui.robot_file.propose import SeveralRobots
    from archo_tui.session.options import Options
    from archo_tui.session.session import Session
    from archo_tui.station.save_load import write_atomically

    if options.engine not in ("", "ros2"):
        raise ArchoError("robot looks at a ROS 2 graph, which the embedded engine has not")
    path = options.out
    if path is not None and os.path.lexists(path):
        raise ArchoError(f"{path} already exists: name another file")
    try:
        with Session(
            Options(engine="ros2", attach=True, watch=True, namespace=options.namespace or "/")
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
    await asyncio.sleep(_SETTLING)
    return await robot_file_text(station)
