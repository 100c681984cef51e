"""The list of recordings, and the replay of one in the console's terminal."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Sequence
from datetime import datetime
from functools import partial
from typing import Any

from textual.binding import Binding

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.base.errors import ArchoError
from archo_tui.base.handover import CONSOLE_SOCKET, GO, STOP_KEY
from archo_tui.base.system import command_line, is_suspended
from archo_tui.recordings import store
from archo_tui.recordings.store import Recording, length_size_and_why
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.screen.commands.base import LONGEST, Command, Desk
from archo_tui.screen.dialog import ListDialog
from archo_tui.screen.terminal.app import COMMANDS, start_worker
from archo_tui.text.columns import Columns, Text, crop

_POLL = 0.1  # Seconds between two looks for an alarm.
_LAST = 0.5  # Seconds in which a replay ends by itself; less than the console itself has to end.


class ShowRecordings(Command):
    id = "recordings"
    help = "List the recordings: when, why, how long; play one, copy its command, delete one"

    async def run(self, desk: Desk) -> None:
        with desk.opening():
            found = await list_recordings(desk)
        if found is not None:
            desk.open(RecordingList(desk, found))


def recording_lines(recording: Recording, width: int, _columns: Columns) -> list[Text]:
    """Return `2026-11-22 03:12:07     65 s      212 kB  STOP, kept`, in local time."""
    when = f"{datetime.fromtimestamp(recording.start):%Y-%m-%d %H:%M:%S}"
    return [(crop(f"{when}  {length_size_and_why(recording)}", width), "")]


async def play(desk: Desk, recording: Recording) -> None:
    """Play a recording in the console's terminal, by a process of its own, until that ends.

    The process says when it could draw, gets the terminal then, and says when STOP was pressed,
    which is sent from here. A STOP, an alarm of high priority and the console's end end the replay;
    so does a signal that suspends it, since it would read no STOP. What was typed meanwhile and
    reached the console is for the replay, and dropped.
    """
    loop, gate, before = asyncio.get_running_loop(), desk.stops.gate(), grave_alarms(desk)

    def start() -> subprocess.Popen[bytes]:
        handed = {CONSOLE_SOCKET: str(its.fileno()), STOP_KEY: desk.stop_key}
        with its:
            return subprocess.Popen(
                command_line(["replay", recording.name]),
                stdin=desk.terminal.fileno,
                stdout=sys.__stdout__,
                stderr=sys.__stderr__,
                pass_fds=[its.fileno()],
                env=os.environ | handed,
            )

    def end() -> None:
        process.terminate()
        if sys.platform != "win32":
            process.send_signal(signal.SIGCONT)  # It may have read a STOP just before.
        try:
            process.wait(_LAST)
        except subprocess.TimeoutExpired:  # It hangs, as on a disk.
            process.kill()
            process.wait()

    def must_end() -> bool:
        is_left = desk.is_ending or is_suspended(process.pid)
        return bool(is_left or gate.is_shut or grave_alarms(desk) - before)

    async def follow(work: asyncio.Future[Any]) -> None:
        while not (work.done() or must_end()):
            await asyncio.wait([work], timeout=_POLL)

    async def obey() -> None:
        """Send each STOP that is pressed in the replay, until its process has ended."""
        with contextlib.suppress(OSError):  # It was killed.
            await loop.sock_sendall(ours, GO)
            while await loop.sock_recv(ours, 1):
                desk.action_command("stop")

    def fail(what: str) -> None:
        text = f"{what}: archo-tui replay {recording.name} tells why"
        desk.report_failure(Outcome(Code.REFUSED, text))

    async def lend() -> None:
        obeying = asyncio.ensure_future(obey())
        try:
            await follow(obeying)
            code = await in_daemon(process.wait) if obeying.done() else 0
        finally:
            await in_daemon(end)
            await obeying  # A STOP may have been pressed until then.
        if code:
            fail("the replay broke off")

    with desk.opening(), contextlib.ExitStack() as stack:
        try:
            ours, its = socket.socketpair()
            stack.enter_context(ours).setblocking(False)
            process = await in_daemon(start)
        except OSError as error:  # As when no process or descriptor is free.
            desk.report_failure(Outcome(Code.REFUSED, f"not played: {error.strerror or error}"))
            return
        ready = asyncio.ensure_future(loop.sock_recv(ours, 1))
        try:
            await asyncio.wait_for(follow(ready), LONGEST)
            if ready.done() and not ready.result():
                fail("not played")
                desk.repaint()  # It may have written on the screen.
            elif ready.done() and not (desk.is_ending or gate.is_shut):
                with desk.lend_terminal():
                    await lend()
        except asyncio.TimeoutError:  # Its disk hangs.
            fail("not played")
        finally:
            ready.cancel()
            await in_daemon(end)
            desk.drop_following_keys("The replay is over")


def grave_alarms(desk: Desk) -> set[tuple[str, float]]:
    """Return the unacknowledged alarms of high priority, each with its name and begin."""
    return {(alarm.name, alarm.since) for alarm in desk.station.view.alarms if alarm.is_urgent}


class RecordingList(ListDialog[Recording]):
    """A list of recordings: enter plays one, y copies the command that does, d deletes it."""

    BINDINGS = [
        Binding("enter", "play", "Play", priority=True),
        Binding("y", "copy", "Copy the command that plays it", priority=True),
        Binding("d,delete", "delete", "Delete", priority=True),
    ]

    keys_text = "enter play   y copy its command   d delete   esc close"

    def __init__(self, desk: Desk, recordings: Sequence[Recording]) -> None:
        """Create the list; the newest recording comes first."""
        super().__init__(
            "Recordings",
            recording_lines,
            lambda recording: recording.name,
            action="screen.play",
        )
        self._desk, self._recordings = desk, recordings

    def on_mount(self) -> None:
        self.rows.show_cursor()
        self.show_items(self._recordings, "No recordings.")

    def action_play(self) -> None:
        """Play the recording under the cursor; where no terminal can be lent, copy its command."""
        if self.rows.item is not None and self._desk.terminal is not None:
            self.dismiss()
            start_worker(self._desk, partial(play, self._desk, self.rows.item), COMMANDS)
        else:
            self.action_copy()

    def action_copy(self) -> None:
        """Copy the command that plays the recording under the cursor; nothing without one."""
        if self.rows.item is not None:
            command = f"archo-tui replay {self.rows.item.name}"
            self._desk.copy_to_clipboard(command)
            self._desk.show_message(f"{command}: run it in another terminal", title="Copied")

    def action_delete(self) -> None:
        """Ask, and delete the recording under the cursor; nothing happens without one."""
        if self.rows.item is not None:
            name = self.rows.item.name
            answers = {"Delete": partial(self._delete, self.rows.item)}
            question = f"Delete {name}? It is gone then."
            self._desk.confirm("Delete a recording", question, "Keep it", answers)

    async def _delete(self, recording: Recording) -> None:
        try:
            await in_daemon(store.delete, recording)
        except OSError as error:
            text = f"not deleted: {error.strerror or error}"
            self._desk.report_failure(Outcome(Code.REFUSED, text))
        else:
            note = f"recording {recording.name} deleted"
            self._desk.station.robot.note("YOU", "console", note)
        found = await list_recordings(self._desk)
        if found is not None and not self.is_dismissed:
            self.show_items(found)


async def list_recordings(desk: Desk) -> list[Recording] | None:
    """Return the recordings, newest first, or None after showing why they cannot be read."""
    try:
        return await in_daemon(store.own_recordings)
    except ArchoError as error:
        desk.report_failure(Outcome(Code.REFUSED, str(error)))
        return None
