"""The socket of a console that restarts: it passes to the next process, and no STOP is lost."""

from __future__ import annotations

import asyncio
import os

import pytest

from archo_tui.base.handover import Handover
from archo_tui.session.options import Options
from archo_tui.session.session import Session
from tests.support import chosen, clock
from tests.support.console import FAST, LONG, console
from tests.support.shells import Raw, heard, raw, reached, served, until

pytestmark = [pytest.mark.real_time, pytest.mark.posix]


def restarted() -> Handover:
    """What a console leaves that restarts; its socket listens, and nobody reads."""
    options = Options(engine=chosen.ENGINE, domain_id=chosen.next_domain(), remote=True)
    session = Session(options, clock.current)
    session.start()
    assert session.close(restarts=True) == []
    left = session.hand_over()
    assert left.listening is not None
    assert os.get_inheritable(left.listening[0])
    return left


async def connected(left: Handover) -> Raw:
    assert left.listening is not None
    one = reached(left.listening[1])
    return Raw(*await asyncio.open_unix_connection(sock=one))


async def test_a_stop_that_is_sent_meanwhile_is_read_first_and_confirmed() -> None:
    left = restarted()
    one, other = await connected(left), await connected(left)
    one.send({"id": 7, "words": ["stop"]})
    other.send({"id": 8, "words": ["go", "3"]})
    async with served(ros_args=FAST, handover=left) as person:
        assert (await one.line())["name"] in left.listening[1]  # type: ignore[index]
        assert (await one.result())["code"] == "done"
        assert (await other.result())["code"] in ("cancelled", "refused", "held")
        await heard(person, "STOP: confirmed")
        one.close()
        other.close()


def test_a_console_that_does_not_start_again_leaves_no_socket() -> None:
    left = restarted()
    assert left.listening is not None
    options = Options(engine=chosen.ENGINE, remote=True, handover=left)
    with pytest.raises(Exception, match="max_speed"):
        Session(options._replace(ros_args=("-p", "max_speed:=fast")), clock.current)
    assert not os.path.exists(left.listening[1])


async def test_who_waits_for_a_goal_is_told_what_the_restart_did_to_it() -> None:
    async with console(*LONG, remote=True) as op:
        one = await raw()
        going = asyncio.create_task(one.ask("go", "30", wait=True))
        await until(lambda: "MOVING" in op.text)
        op.session.station.restart("interfaces were saved")
        result = await going
        one.close()
    told = result["code"], result["text"]
    assert told == ("cancelled", "Cancelled mid-route: the console restarts")
