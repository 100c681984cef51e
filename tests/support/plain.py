"""`--plain` in the test's own process: what is typed all at once, and what is said."""

from __future__ import annotations

import asyncio
import os
from pathlib import Path
from typing import Any

from archo_tui.plain import Plain
from archo_tui.session import Options, Session
from tests.support import chosen, clock
from tests.support.quiet import Quiet


async def plain(typed: str, *makers: Any, robot: Path | None = None, **options: Any) -> Any:
    """The exit code and the output."""
    given = {"domain_id": chosen.next_domain(), "node_makers": makers, **options}
    in_, writes = os.pipe()
    said, out = os.pipe()
    with Session(Options(engine=chosen.ENGINE, robot=robot, **given), clock.current) as session:
        running = asyncio.ensure_future(Plain(session.station, in_, out).run())
        os.write(writes, typed.encode())
        os.close(writes)
        await Quiet().until(running.done, lambda: "the end")
        code = await running
    os.close(out)
    text = os.read(said, 100_000).decode()
    for descriptor in (in_, said):
        os.close(descriptor)
    return code, text
