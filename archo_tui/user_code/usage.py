"""The processor time and memory that a node or program of the console takes."""

from __future__ import annotations

import os
import sys
import threading
import time
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
    if sys.platform != "linux":
        return None
    alive = [thread for thread in threads if thread.is_alive() and thread.ident is not None]
    try:
        clocks = [time.pthread_getcpuclockid(thread.ident or 0) for thread in alive]
        cpu = sum(map(time.clock_gettime, clocks))
    except OSError:  # One has just ended.
        return None
    return Usage(cpu, None, f"{len(alive)} thread{'s' * (len(alive) != 1)} of this process")


def of_process(number: int) -> Usage | None:
    """Return what a process has taken; None if it has ended, or where the system does not tell."""
    if sys.platform != "linux":
        return None
    try:
        stat = Path(f"/proc/{number}/stat").read_text(errors="replace")
        pages = int(Path(f"/proc/{number}/statm").read_text().split()[1])
    except OSError:
        return None
    fields = stat.rpartition(")")[2].split()  # Behind the name, which may be anything.
    ticks = int(fields[11]) + int(fields[12])  # In user and in kernel mode: see proc(5).
    memory = pages * os.sysconf("SC_PAGE_SIZE")
    return Usage(ticks / os.sysconf("SC_CLK_TCK"), memory, f"process {number}")


def usage_text(before: Usage | None, now: Usage, seconds: float) -> str:
    """Return `process 4711: 3 % of one core, 61 MB`, by a measurement `seconds` before."""
    parts = []
    if before is not None and before.where == now.where and seconds > 0:
        parts.append(f"{max(now.cpu - before.cpu, 0.0) / seconds:.0%} of one core")
    parts.append(f"{now.cpu:.1f} s of processor time")
    if now.memory is not None:
        parts.append(f"{now.memory / 1e6:.0f} MB")
    return f"{now.where}: {', '.join(parts)}"
