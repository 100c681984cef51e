"""The commands that give a name to where the robot is, and to the goals of the queue."""

from __future__ import annotations

from archo_tui.commands.base import Desk, VerbCommand
from archo_tui.errors import ArchoError
from archo_tui.screens.dialog import Form
from archo_tui.terminal.app import COMMANDS, start_worker
from archo_tui.verbs.verb import Verb


class SaveUnderName(VerbCommand):
    """The command that asks for a name, and runs a verb with it."""

    def __init__(self, verb: Verb, *others: str) -> None:
        """Create it; `others` are the verbs that use what it saves."""
        super().__init__(verb)
        self.verbs = (verb.id, *others)

    def run(self, desk: Desk) -> None:
        desk.open(AskName(desk, self.verb))


class AskName(Form):
    """A dialog with a field for a name, which stays open until the verb with it succeeds."""

    submit_label = "Save"

    def __init__(self, desk: Desk, verb: Verb) -> None:
        super().__init__("name", title=verb.title, text=f"{verb.help}:")
        self._desk, self._verb = desk, verb

    def submit(self, typed: str) -> None:
        """Begin to run the verb with the typed name; a second call is ignored."""
        if not self.is_asking:
            self.is_asking = True
            start_worker(self.app, lambda: self._save(typed.strip()), COMMANDS)

    async def _save(self, name: str) -> None:
        station = self._desk.station
        try:
            values = await self._verb.prepare(station, self._verb.values([name]))
            outcome = await self._verb.run(station, values)
        except (ArchoError, ValueError) as error:
            self.show_message(str(error))
        else:
            self._desk.show_message(outcome.text)
            self.dismiss()
        finally:
            self.is_asking = False
