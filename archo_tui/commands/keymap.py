"""Keys of the operator's own choice: `keymap.yaml` in the configuration folder, `command: key`."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import yaml
from textual._ansi_sequences import ANSI_SEQUENCES_KEYS
from textual.keys import _character_to_key, format_key

from archo_tui.commands.base import EVERYWHERE, IN_PANEL, Command
from archo_tui.errors import ArchoError
from archo_tui.yaml_text import bounded_yaml

_OTHER = "choose another"
_SHOWN = 20  # characters of a wrong name that are shown
_RESERVED = (
    *("tab", "shift+tab", "escape", "up", "down", "left", "right", "enter"),
    *("backspace", "delete", "home", "end"),
)
# what terminals send, by the names that Textual gives it
_SENT = {
    key.value for keys in ANSI_SEQUENCES_KEYS.values() if isinstance(keys, tuple) for key in keys
}
_SENT_AS = {
    "ctrl+i": "tab",
    "ctrl+m": "enter",
    "ctrl+h": "backspace",
    "ctrl+[": "escape",
    "ctrl+left_square_bracket": "escape",
}


def load(path: Path, commands: Iterable[Command]) -> tuple[dict[str, str], str]:
    """The key of every command by its id, and a line about those that this robot does not have.

    One keymap serves several robots. A command that yields has no key when another took it.
    Raises ArchoError that names the line.
    """
    commands = list(commands)
    keys = robots_keys(commands)
    known = {command.id: command for command in commands}
    lines: dict[str, int] = {}
    others: list[str] = []
    for line, name, key in _entries(path):
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1)
            hint = f", nearest: {near[0]}" if near else ""
            others.append(f"{name} (line {line}{hint})")
            continue
        keys[name] = _checked(f"{path}:{line}", known[name], key)
        lines[name] = line
    yielding = [command for command in commands if command.yields and command.id not in lines]
    for command in yielding:
        if who_has(command, keys[command.id], keys, commands):
            keys[command.id] = ""
    for name, line in lines.items():
        other = who_has(known[name], keys[name], keys, commands)
        if other:
            raise ArchoError(f"{path}:{line}: {keys[name]} is already the key of {other}")
    said = f"{path}: this robot has no command {', '.join(others)}: left out" if others else ""
    return keys, said


def robots_keys(commands: Sequence[Command]) -> dict[str, str]:
    """The keys that commands come with; those of a robot file are checked, and take no other's.

    Raises ArchoError that names the robot file's line.
    """
    keys = {command.id: command.key for command in commands if not command.from_file}
    core = {c.key: c.id for c in commands if c.key and not c.from_file and not c.yields}
    for command in commands:
        if not command.from_file:
            continue
        keys[command.id] = command.key and _checked(command.from_file, command, command.key)
        owner = core.get(keys[command.id])
        if owner:
            raise ArchoError(f"{command.from_file}: {command.key} is the key of {owner}: {_OTHER}")
        if keys[command.id]:
            core[keys[command.id]] = command.id
    return keys


def who_has(
    command: Command, key: str, keys: Mapping[str, str], commands: Iterable[Command]
) -> str:
    """The id of another command that has the key where this one would get it; empty: none has."""
    others = (c.id for c in commands if c is not command and _meet(command, c))
    return next((name for name in others if key and keys[name] == key), "")


def readable(key: str) -> str:
    """A key as a person reads it: `^x`, `?`, `enter`."""
    if key in ("", "enter"):
        return key
    return format_key(key).replace("ctrl+", "^")


def _entries(path: Path) -> Iterable[tuple[int, str, str]]:
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


def _checked(where: str, command: Command, key: str) -> str:
    name = _character_to_key(key) if len(key) == 1 else key.lower()
    types = _types_text(name)
    if name in _SENT_AS:
        raise ArchoError(f"{where}: a terminal sends {key} as {_SENT_AS[name]}: {_OTHER}")
    if not types and name not in _SENT:
        raise ArchoError(f"{where}: no key {key[:_SHOWN]!r}: like x, ctrl+x, f5, question_mark")
    if name in _RESERVED and (command.key != name or command.from_file):
        raise ArchoError(f"{where}: {key} is needed in fields and dialogs: {_OTHER}")
    if types and command.where == EVERYWHERE:
        raise ArchoError(
            f"{where}: {command.id} must work while typing too: "
            f"{key} would be text, choose one like ctrl+{key[0]} or f5"
        )
    return name


def _types_text(name: str) -> bool:
    return name == "space" or (len(format_key(name)) == 1 and name not in _SENT)


def _meet(one: Command, other: Command) -> bool:
    """True when there is a place where both would get the key."""
    both = one.where == other.where == IN_PANEL
    return not both or one.panel == other.panel


def shown_keys(keys: Mapping[str, str]) -> dict[str, str]:
    """Every command's key as a person reads it."""
    return {command: readable(key) for command, key in keys.items()}
