"""The command that lists recordings."""

from __future__ import annotations

from typing import TYPE_CHECKING

from archo_tui.commands.base import Command, Desk, Work
from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError, in_one_line
from archo_tui.robot.outcome import Code, Outcome

if TYPE_CHECKING:
    from archo_tui.clock import Clock
    from archo_tui.recordings.replay.player import Player
    from archo_tui.recordings.store import Recording
    from archo_tui.screens.lists import RecordingList


class ShowRecordings(Command):
    id = "recordings"
    help = "List the recordings: when, why, how long; play one, delete one"

    def run(self, desk: Desk) -> Work:
        return self._show(desk)

    async def _show(self, desk: Desk) -> None:
        from archo_tui.screens.lists import RecordingList

        with desk.live.opening():
            found = await _list_recordings(desk)
        if found is None:
            return

        def play(recording: Recording) -> Work:
            return _open_replay(desk, recording, dialog)

        def copy(recording: Recording) -> None:
            command = f"archo-tui replay {recording.name}"
            desk.live.copy_to_clipboard(command)
            desk.show_message(command, title="Copied the command")

        def ask(recording: Recording) -> None:
            question = f"Delete {recording.name}? It is gone then."
            answers = {"Delete": lambda: self._delete(desk, recording, dialog)}
            desk.live.confirm("Delete a recording", question, "Keep it", answers)

        dialog = RecordingList(found, play, copy, ask)
        desk.live.open(dialog)

    async def _delete(self, desk: Desk, recording: Recording, dialog: RecordingList) -> None:
        from archo_tui.recordings import store

        try:
            await in_daemon(store.delete, recording)
        except OSError as error:
            desk.report_failure(Outcome(Code.REFUSED, f"not deleted: {error.strerror or error}"))
        else:
            desk.station.robot.note("YOU", "console", f"recording {recording.name} deleted")
        found = await _list_recordings(desk)
        if found is not None and not dialog.is_dismissed:
            dialog.show_items(found)


async def _open_replay(desk: Desk, recording: Recording, dialog: RecordingList) -> None:
    """Load a recording on another thread; show it in place of the list, or say why not."""
    try:
        player = await in_daemon(_open, recording, desk.station.clock)
    except ArchoError as error:
        said = str(error)
    except Exception as error:  # A damaged file may raise anything; the live console goes on.
        said = f"{recording.name}: {in_one_line(error)}"
    else:
        if dialog.is_active and not dialog.is_dismissed:
            dialog.dismiss()
            desk.live.begin_replay(player)
            return
        player.close()
        if dialog.is_dismissed:  # The operator has closed it meanwhile.
            return
        said = "another dialog was opened meanwhile"
    desk.report_failure(Outcome(Code.REFUSED, f"not played: {said}"))


def _open(recording: Recording, clock: Clock) -> Player:
    from archo_tui.recordings.replay.player import load_robot_file, make_player, open_bag

    bag = open_bag(str(recording.folder))
    return make_player(bag, load_robot_file(bag, ""), clock)


async def _list_recordings(desk: Desk) -> list[Recording] | None:
    """Return the recordings, newest first, or None after showing why they cannot be read."""
    from archo_tui.recordings import store

    try:
        return await in_daemon(store.own_recordings)
    except ArchoError as error:
        desk.report_failure(Outcome(Code.REFUSED, str(error)))
        return None
