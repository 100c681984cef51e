"""The command that lists recordings."""

from __future__ import annotations

from archo_tui.commands.base import Command, Desk, Work


class ShowRecordings(Command):
    id = "recordings"
    help = "List the recordings: when, why, how long; play one, delete one"

    def run(self, desk: Desk) -> Work:
        return self._show(desk)

    async def _show(self, desk: Desk) -> None:
        from archo_tui.commands.lists import RecordingList, list_recordings

        with desk.live.opening():
            found = await list_recordings(desk)
        if found is not None:
            desk.live.open(RecordingList(desk, found))
