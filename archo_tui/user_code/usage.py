"""The processor time and memory that a node or program of the console takes."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple


class Usage(NamedTuple):
    """The processor time and memory that threads or a process have taken so far."""

    cpu: float  # Seconds of processor time.
    memory: int | None  # Bytes; None for threads, which share that of the console.
    where: str  # `2 threads of this process`, `process 4711`


def of_threads(threads: Iterable[threading.Thread]) -> Usage | None:
    """Return what threads have taken; None where the system does not tell it."""
    numbers = [thread.native_id for thread in threads if thread.is_alive()]
    taken = [_cpu(f"/proc/self/task/{number}/stat") for number in numbers]
    found = [seconds for seconds in taken if seconds is not None]
    where = f"{len(found)} thread{'s' * (len(found) != 1)} of this process"
    return Usage(sum(found), None, where) if found else None


def of_process(number: int) -> Usage | None:
    """Return what a process has taken; None if it has ended, or where the system does not tell."""
    cpu = _cpu(f"/proc/{number}/stat")
    if cpu is None or sys.platform != "linux":
        return None
    try:
        pages = int(Path(f"/proc/{number}/statm").read_text().split()[1])
    except OSError:
        return None
    return Usage(cpu, pages * os.sysconf("SC_PAGE_SIZE"), f"process {number}")


def _cpu(stat: str) -> float | None:
    """Return the seconds of processor time in a file of proc(5); None if it is not there."""
    if sys.platform != "linux":
        return None
    try:
        text = Path(stat).read_text(errors="replace")
    except OSError:
        return None
    fields = text.rpartition(")")[2].split()  # Behind the name, which may be anything.
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")  # User and kernel mode.


def usage_text(before: Usage | None, now: Usage, seconds: float) -> str:
    """Return `process 4711: 3 % of one core, 61 MB`, by a measurement `seconds` before."""
    parts = []
    if before is not None and before.where == now.where and seconds > 0:
        parts.append(f"{max(now.cpu - before.cpu, 0.0) / seconds:.0%} of one core")
    parts.append(f"{now.cpu:.1f} s of processor time")
    if now.memory is not None:
        parts.append(f"{now.memory / 1e6:.0f} MB")
    return f"{now.where}: {', '.join(parts)}"
