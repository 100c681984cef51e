"""The commands that give a name to where the robot is, and to the goals of the queue."""

from __future__ import annotations

from archo_tui.commands.base import Desk, VerbCommand
from archo_tui.errors import ArchoError
from archo_tui.verbs.verb import Verb


class SaveUnderName(VerbCommand):
    """The command that asks for a name, and runs a verb with it."""

    def __init__(self, verb: Verb, *others: str) -> None:
        """Create it; `others` are the verbs that use what it saves."""
        super().__init__(verb)
        self.verbs = (verb.id, *others)

    def run(self, desk: Desk) -> None:
        from archo_tui.screens.ask_name import AskName

        station = desk.station

        async def save(name: str) -> str:
            try:
                values = await self.verb.prepare(station, self.verb.values([name]))
                outcome = await self.verb.run(station, values)
            except (ArchoError, ValueError) as error:
                return str(error)
            desk.show_message(outcome.text)
            return ""

        desk.live.open(AskName(self.verb.title, f"{self.help}:", save))
