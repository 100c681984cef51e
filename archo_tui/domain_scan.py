"""A look at ROS 2 domains for nodes, in a process of its own.

Run as `python -m archo_tui.domain_scan`: it joins each domain, waits, and prints a JSON object with
the nodes by domain. In the console's own process a participant in each of so many domains would
stay until its end.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import sys
import time
from collections.abc import Mapping, Sequence

DOMAINS = range(21)  # ROS_DOMAIN_ID 0 to 20: those that people choose by hand.
_DISCOVERY = 3.0  # Seconds in which nodes answer.
_TIMEOUT = 30.0  # Seconds for the process.
_MOST_BYTES = 10_000_000  # Of the answer: the names of tens of thousands of nodes.


class ScanError(Exception):
    """The error that the domains could not be looked at; its text says why, in one line."""


async def find_nodes() -> Mapping[int, Sequence[str]]:
    """Return the nodes in each of DOMAINS that has any; ScanError if that fails.

    It starts a process, which takes some seconds. Hidden nodes are left out.
    """
    try:
        return await _ask_process()
    except (OSError, ValueError, TimeoutError) as error:
        raise ScanError(f"the domains could not be looked at: {error}") from None


async def _ask_process() -> Mapping[int, Sequence[str]]:
    """Start the process, wait for its answer, end it, and return the nodes by domain."""
    # The same modules, also those of a zip file.
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "archo_tui.domain_scan",
        env=environment,
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
        limit=_MOST_BYTES,
    )
    assert process.stdout is not None
    try:
        out = await asyncio.wait_for(process.stdout.readline(), _TIMEOUT)
    except asyncio.TimeoutError:  # Not the builtin TimeoutError before Python 3.11.
        raise TimeoutError(f"no answer in {_TIMEOUT:g} s") from None
    finally:
        # To leave twenty-one domains one after the other would take seconds.
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()
    if not out:
        raise ValueError("ROS 2 did not start in a process of its own")
    return {int(domain): nodes for domain, nodes in json.loads(out).items()}


def main() -> None:
    """Print the nodes of each domain that has any, as a JSON object on one line."""
    from archo_tui import engine

    engine.activate("ros2")
    import rclpy
    from rclpy.context import Context
    from rclpy.signals import SignalHandlerOptions

    nodes = {}
    for domain in DOMAINS:
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
    sys.stdout.write(f"{json.dumps(found)}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
