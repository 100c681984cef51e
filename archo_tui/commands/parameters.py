"""Commands of the parameters' panel."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from archo_tui.commands.base import (
    IN_PANEL,
    PARAMETERS,
    Answers,
    Command,
    Console,
    Work,
    write_file,
)
from archo_tui.daemon_threads import in_daemon
from archo_tui.errors import ArchoError
from archo_tui.parameters import save_load
from archo_tui.robot.state import Parameter
from archo_tui.robot.values import text_of
from archo_tui.screens.ask_path import AskPath
from archo_tui.screens.edit_parameter import EditParameter

_DEFAULT_FILE = "archo_params.yaml"


class _InParameters(Command):
    where, panel = IN_PANEL, PARAMETERS

    def blocked(self, console: Console) -> str:
        return "" if console.view.snapshot.parameters else "no node has reported its parameters yet"


class Edit(_InParameters):
    acts = True
    id, key = "edit", "enter"
    help = "Edit the selected parameter"

    def run(self, console: Console) -> None:
        parameter = console.main.parameters.selected
        if parameter is not None:
            node, name, change = parameter.node, parameter.name, console.station.set_parameters
            send = lambda value: change(node, {name: value})  # noqa: E731
            console.open(EditParameter(parameter, send, self.offered(parameter)))

    def offered(self, parameter: Parameter) -> Any:
        """What stands in the field at first."""
        return parameter.value


class Restore(Edit):
    id, key = "restore", "backspace"
    help = "Edit the selected parameter, with the value that it had at the start"

    def offered(self, parameter: Parameter) -> Any:
        return parameter.initial


class Switch(_InParameters):
    acts = True
    id, key = "switch", "space"
    help = "Switch the selected boolean parameter"
    once = True

    def blocked(self, console: Console) -> str:
        selected = console.main.parameters.selected
        if selected is None or not isinstance(selected.value, bool):
            return "the selected parameter is not a boolean"
        return f"{selected.name} is read-only" if selected.read_only else ""

    def run(self, console: Console) -> Work | None:
        selected = console.main.parameters.selected
        assert selected is not None
        changed = {selected.name: not selected.value}

        async def switch() -> None:
            console.tell(await console.station.set_parameters(selected.node, changed))

        return switch()


class OnlyChanged(_InParameters):
    id, key = "only_changed", "d"
    help = "Show only parameters that differ from the start, with both values; or all again"

    def run(self, console: Console) -> None:
        console.main.parameters.toggle_changed()


class Filter(_InParameters):
    id, key = "filter", "slash"
    help = "Show only parameters whose node, name or value contains what you type"

    def run(self, console: Console) -> None:
        console.main.parameters.search.open()


class Undo(_InParameters):
    acts = True
    id, key = "undo", "u"
    help = "Undo your last change of a parameter"
    once = True

    def blocked(self, console: Console) -> str:
        return console.station.edits.blocked(console.view.snapshot)

    def run(self, console: Console) -> Work | None:
        edit = console.station.edits.last
        assert edit is not None

        async def undo() -> None:
            console.tell(await console.station.undo())

        others = console.station.edits.changed_since(console.view.snapshot)
        if not others:
            return undo()
        said = " ".join(
            f"{name} has since changed to {text_of(value)}. Restore {text_of(edit.before[name])}?"
            for name, value in others.items()
        )
        console.confirm("Undo", said, "Leave it", {"Restore": undo})
        return None


class Save(_InParameters):
    id, key = "save", "ctrl+s"
    help = "Save all parameters to a ROS parameter file"

    def run(self, console: Console) -> None:
        text, left_out = save_load.dump(console.view.snapshot.parameters)
        write = write_file(console, text, "save parameters")

        async def save(path: Path) -> str:
            said = await write(path)
            for line in () if said else left_out:
                why = f"not saved, a parameter file cannot hold it: {line}"
                console.station.robot.note("WARN", "console", why)
            return said

        console.open(AskPath("Save parameters", "ROS parameter file", _DEFAULT_FILE, save))


class Load(_InParameters):
    acts = True
    id, key = "load", "ctrl+o"
    help = "Load a ROS parameter file; first shows what would change"

    def run(self, console: Console) -> None:
        async def load(path: Path) -> str:
            try:
                parameters = console.view.snapshot.parameters
                plan = await in_daemon(save_load.plan, path, parameters)
            except ArchoError as error:
                return str(error)
            if dialog.has_left:  # nobody wants it any more
                return ""
            dialog.dismiss()  # before the question, which would else be under it
            self._preview(console, path, plan)
            return ""

        dialog = AskPath("Load parameters", "ROS parameter file", _DEFAULT_FILE, load)
        console.open(dialog)

    def _preview(self, console: Console, path: Path, plan: save_load.Plan) -> None:
        lines = [f"{path}", ""]
        if plan.problems:
            lines += ["Nothing was changed, because of:", *plan.problems]
        else:
            lines += [
                f"{p.node.lstrip('/')} {p.name}: {text_of(p.value)} -> {text_of(value)}"
                for p, value in plan.changes
            ] or ["All parameters already have the values in the file."]
            lines += [f"left out: {line}" for line in plan.left_out]

        async def change() -> None:
            by_node: dict[str, dict[str, object]] = {}
            for parameter, value in plan.changes:
                by_node.setdefault(parameter.node, {})[parameter.name] = value
            for node, values in by_node.items():
                console.tell(await console.station.set_parameters(node, values))

        can = plan.changes and not plan.problems
        answers: Answers = {f"Change {len(plan.changes)}": change} if can else {}
        console.confirm("Load parameters", "\n".join(lines), "Cancel", answers)
