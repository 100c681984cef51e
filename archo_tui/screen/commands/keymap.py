"""The operator's own keys: `keymap.yaml` in the configuration folder, with lines `command: key`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import yaml
from textual.keys import Keys, format_key

from archo_tui.base.errors import ArchoError
from archo_tui.base.nearest import nearest
from archo_tui.base.yaml_text import bounded_yaml
from archo_tui.screen.commands.base import EVERYWHERE, IN_PANEL, Command
from archo_tui.screen.terminal.keyboard import key_name

_CHOOSE_ANOTHER = "choose another"
_SHOWN = 20  # Characters of a wrong key that an error quotes.
_RESERVED = (
    *("tab", "shift+tab", "escape", "up", "down", "left", "right", "enter"),
    *("backspace", "delete", "home", "end"),
)
# The keys that terminals send, by Textual's names.
_TERMINAL_KEYS = {key.value for key in Keys} - {"<any>", "<ignore>", "ctrl-at", "return"}
_INDISTINGUISHABLE = {
    "ctrl+i": "tab",
    "ctrl+m": "enter",
    "ctrl+h": "backspace",
    "ctrl+[": "escape",
    "ctrl+left_square_bracket": "escape",
}


def load_keymap(path: Path, commands: Iterable[Command]) -> tuple[dict[str, str], str]:
    """Return the keys of all commands by id as a keymap file changes them, and a line on others.

    One keymap serves several robots, so unknown commands are no error. A command that gives way
    loses its default key to another one that has it: its key is "". ArchoError names the line.
    """
    commands = list(commands)
    keys = default_keys(commands)
    known = {command.id: command for command in commands}
    lines: dict[str, int] = {}
    others: list[str] = []
    for line, name, key in _read_entries(path):
        if name not in known:
            near = nearest(name, known)
            hint = f", nearest: {near}" if near else ""
            others.append(f"{name} (line {line}{hint})")
            continue
        keys[name] = _checked_key(f"{path}:{line}", known[name], key)
        lines[name] = line
    yielding = [command for command in commands if command.gives_way and command.id not in lines]
    for command in yielding:
        if key_owner(command, keys[command.id], keys, commands):
            keys[command.id] = ""
    for name, line in lines.items():
        other = key_owner(known[name], keys[name], keys, commands)
        if other:
            raise ArchoError(f"{path}:{line}: {keys[name]} is already the key of {other}")
    note = f"{path}: this robot has no command {', '.join(others)}: left out" if others else ""
    return keys, note


def default_keys(commands: Sequence[Command]) -> dict[str, str]:
    """Return the keys of commands by id, the robot file's included, before a keymap changes them.

    A key of a command that gives way may be a second one's, too. ArchoError names the line of a
    robot file's key that is not valid or taken.
    """
    keys = {command.id: command.key for command in commands if not command.from_file}
    core = {c.key: c.id for c in commands if c.key and not c.from_file and not c.gives_way}
    for command in commands:
        if not command.from_file:
            continue
        keys[command.id] = command.key and _checked_key(command.from_file, command, command.key)
        owner = core.get(keys[command.id])
        if owner:
            raise ArchoError(
                f"{command.from_file}: {command.key} is the key of {owner}: {_CHOOSE_ANOTHER}"
            )
        if keys[command.id]:
            core[keys[command.id]] = command.id
    return keys


def key_owner(
    command: Command, key: str, keys: Mapping[str, str], commands: Iterable[Command]
) -> str:
    """Return the id of another command that has a key where this one works, or ""."""
    others = (c.id for c in commands if c is not command and _overlap(command, c))
    return next((name for name in others if key and keys[name] == key), "")


def _read_entries(path: Path) -> Iterable[tuple[int, str, str]]:
    try:
        root = bounded_yaml.compose(bounded_yaml.read(path), path)
    except (FileNotFoundError, NotADirectoryError):
        return
    except OSError as error:
        raise ArchoError(f"{path}: cannot read the keymap: {error.strerror}") from None
    except bounded_yaml.YamlError as error:
        raise ArchoError(str(error)) from None
    if root is None:
        return
    if not isinstance(root, yaml.MappingNode):
        raise ArchoError(f"{path}:{root.start_mark.line + 1}: expected lines like 'stop: ctrl+x'")
    for name, key in root.value:
        line = name.start_mark.line + 1
        if not (isinstance(name, yaml.ScalarNode) and isinstance(key, yaml.ScalarNode)):
            raise ArchoError(f"{path}:{line}: expected 'command: key'")
        yield line, name.value, key.value


def _checked_key(where: str, command: Command, key: str) -> str:
    name = key_name(key) if len(key) == 1 else key.lower()
    types = _types_a_character(name)
    if name in _INDISTINGUISHABLE:
        raise ArchoError(
            f"{where}: a terminal sends {key} as {_INDISTINGUISHABLE[name]}: {_CHOOSE_ANOTHER}"
        )
    if not types and name not in _TERMINAL_KEYS:
        raise ArchoError(f"{where}: no key {key[:_SHOWN]!r}: like x, ctrl+x, f5, question_mark")
    if name in _RESERVED and (command.key != name or command.from_file):
        raise ArchoError(f"{where}: {key} is needed in fields and dialogs: {_CHOOSE_ANOTHER}")
    if types and command.where == EVERYWHERE:
        raise ArchoError(
            f"{where}: {command.id} must work while typing too: "
            f"{key} would be text, choose one like ctrl+{key[0]} or f5"
        )
    return name


def _types_a_character(name: str) -> bool:
    return name == "space" or (len(format_key(name)) == 1 and name not in _TERMINAL_KEYS)


def _overlap(first: Command, second: Command) -> bool:
    """Return True if both keys work in some same place; only different panels do not overlap."""
    both = first.where == second.where == IN_PANEL
    return not both or first.panel == second.panel
