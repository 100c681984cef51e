"""Programs beside a screen: what is shown of them, their STOPs, its crash, its end and restart."""

from __future__ import annotations

import asyncio
import json
import os

import pytest

from archo_tui.base.handover import Handover
from archo_tui.base.paths import journal_file
from archo_tui.client import sockets
from archo_tui.screen.keyed_app import HELD
from archo_tui.session.options import Options
from archo_tui.session.session import Session
from tests.support import chosen, clock
from tests.support.clock import seconds
from tests.support.console import FAST, LONG, Console, console
from tests.support.shells import (
    Raw,
    guest,
    heard,
    own_socket,
    raw,
    reached,
    said,
    served,
    typed,
    until,
)
from tests.support.terminal import Terminal
from tests.terminal.test_terminal import FAIL_ONCE, SLOW

pytestmark = pytest.mark.real_time


async def reachable(op: Console) -> None:
    await op.until(own_socket)


async def test_who_is_connected_and_what_it_sent_is_on_screen_and_in_the_journal() -> None:
    async with console(*LONG, remote=True) as op:
        await reachable(op)
        one, two = await raw(), await raw()
        assert "shell" not in op.text.splitlines()[0]
        assert (await one.ask("go", "12"))["code"] == "accepted"
        await op.until(lambda: " 1 shell " in op.text.splitlines()[0])
        assert (await two.ask("wait", "arrived", timeout=0))["code"] == "ran_out"
        await op.until(lambda: " 2 shells " in op.text.splitlines()[0])
        line = op.line("go to shelf 12: accepted")
        assert f"shell pid {os.getpid()}: " in " ".join(line.split())
        one.close()
        two.close()
        await op.until(lambda: "shell " not in op.text.splitlines()[0])
        await op.until("MOVING")  # it was not waited for: the console's now
        await op.press("ctrl+c")
        await op.until("CANCELLED")
    entries = [json.loads(line) for line in journal_file().read_text().splitlines()]
    sent = next(entry for entry in entries if "go to shelf 12" in entry["text"])
    assert (sent["kind"], sent["level"]) == ("command", "SHELL")
    assert (sent["source"], sent["verb"], sent["code"]) == (f"pid {os.getpid()}", "go", "accepted")


async def test_a_stop_of_a_shell_closes_the_question_on_the_screen() -> None:
    async with console(*FAST, remote=True) as op:
        await reachable(op)
        assert (await typed("stop")).code == 0
        await op.until("STOPPED")
        await op.press("R")
        await op.until("Release the stop?")
        assert (await typed("stop")).code == 0
        await op.until(lambda: "Release the stop?" not in op.text)
        await op.at(seconds() + HELD)  # what comes at once may be for the question
        await op.press("R")  # asked behind it
        await op.until("Release the stop?")


async def test_a_shell_that_waits_is_told_how_its_goal_ends_when_the_console_quits() -> None:
    async with console(*LONG, remote=True) as op:
        await reachable(op)
        one = await raw()
        one.send({"id": 1, "words": ["go", "12", "7"], "wait": True})
        await op.until("MOVING")
        await op.press("q")
        await op.until("Cancel goal and quit")
        await op.press("tab", "enter")
        said = await one.result()
        assert (said["code"], said["text"]) == ("cancelled", "Cancelled mid-route")
        one.close()


def listening(terminal: Terminal) -> None:
    """Until programs can reach the console in it."""
    terminal.until(lambda: sockets.socket_paths())
    terminal.until("max_speed")


def test_a_screen_that_crashes_ends_a_wait_honestly_and_serves_the_next_program(
    terminals: list[Terminal],
) -> None:
    terminal = Terminal(*SLOW, code=FAIL_ONCE)
    terminals.append(terminal)
    listening(terminal)
    lost = said("go", "12", "--wait")
    assert lost.code == 3
    assert lost.err.endswith("the console is gone; the robot may still be moving\n")
    terminal.until("The screen crashed and was restarted")
    assert said("wait", "arrived", "--timeout", "0").code == 4  # the goal runs on
    assert said("stop") == (0, "", "confirmed\n")
    terminal.until("STOPPED")


def test_no_remote_leaves_the_socket_out(terminals: list[Terminal]) -> None:
    terminal = Terminal("--no-remote")
    terminals.append(terminal)
    terminal.until("max_speed")
    assert said("status").code == 3
    assert not sockets.socket_paths()


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
    async with console(*LONG, remote=True) as op, guest() as one:
        going = asyncio.create_task(one.ask("go", "30", wait=True))
        await until(lambda: "MOVING" in op.text)
        op.session.station.restart("interfaces were saved")
        result = await going
    told = result["code"], result["text"]
    assert told == ("cancelled", "Cancelled mid-route: the console restarts")
