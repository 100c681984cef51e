"""Texts with `$(name ARGUMENT ...)` in them, as XML and YAML launch files write substitutions."""

from __future__ import annotations

import re
import shlex
from typing import Any

from archo_tui.launch.stand_ins import substitutions
from archo_tui.launch.stand_ins.absent import absent_class
from archo_tui.launch.stand_ins.core import (
    Substitution,
    SubstitutionFailure,
    TextSubstitution,
    calling_place,
)
from archo_tui.nearest import nearest_hint

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")
_DOLLAR = r"\$(?!\()|(?<=\\)\$"  # One that begins no substitution.
_TEXT = re.compile(rf"(?:[^$]|{_DOLLAR})+")
_QUOTED = {quote: re.compile(rf"(?:[^$\\{quote}]|{_DOLLAR}|\\{quote}?)+") for quote in "'\""}
# An argument without quotes around it; within quotes, those of the other kind are characters.
_WORDS = {
    quote: re.compile(rf"(?:[^ $()\\{own}]|{_DOLLAR}|\\[(){own}]?)+")
    for quote, own in (("", "'\""), ("'", "'"), ('"', '"'))
}


# Each substitution by its name, with the names of its arguments; those after `|` are optional.
_SUBSTITUTIONS: dict[str, tuple[Any, str]] = {
    "anon": (substitutions.AnonName, "name"),
    "and": (substitutions.AndSubstitution, "left right"),
    "command": (absent_class("launch.substitutions", "Command"), "command | on_stderr"),
    "dirname": (substitutions.ThisLaunchFileDir, ""),
    "env": (substitutions.EnvironmentVariable, "name | default_value"),
    "equals": (substitutions.EqualsSubstitution, "left right"),
    "eval": (substitutions.PythonExpression, "expression | python_modules"),
    "exec-in-pkg": (
        absent_class("launch_ros.substitutions", "ExecutableInPackage"),
        "name package",
    ),
    "file-content": (substitutions.FileContent, "path"),
    "filename": (substitutions.ThisLaunchFile, ""),
    "find-exec": (absent_class("launch.substitutions", "FindExecutable"), "name"),
    "find-pkg-prefix": (substitutions.FindPackagePrefix, "package"),
    "find-pkg-share": (substitutions.FindPackageShare, "package"),
    "if": (substitutions.IfElseSubstitution, "condition if_value | else_value"),
    "launch_log_dir": (absent_class("launch.substitutions", "LaunchLogDir"), ""),
    "log_dir": (absent_class("launch.substitutions", "LaunchLogDir"), ""),
    "not": (substitutions.NotSubstitution, "value"),
    "not-equals": (substitutions.NotEqualsSubstitution, "left right"),
    "or": (substitutions.OrSubstitution, "left right"),
    "param": (substitutions.Parameter, "name | default"),
    "var": (substitutions.LaunchConfiguration, "variable_name | default"),
}
_OF_ANY_NUMBER = {"any": substitutions.AnySubstitution, "all": substitutions.AllSubstitution}


def substitutions_in(text: str) -> list[Substitution]:
    """Return the substitutions of a text, and the texts between them; raise SubstitutionFailure."""
    if not text:
        return [TextSubstitution(text="")]
    parts, end = _Reader(text).parts(0, _TEXT, "")
    assert end == len(text), (text, end)
    return parts


def words_in(text: str) -> list[list[Substitution]]:
    """Return the words of a command line, each with its substitutions, as a shell splits them."""
    words: list[list[Substitution]] = [[]]
    for part in substitutions_in(text):
        if not isinstance(part, TextSubstitution):
            words[-1].append(part)
            continue
        for number, word in enumerate(shlex.split(part.text)):
            if number or part.text[0].isspace():
                words.append([])
            words[-1].append(TextSubstitution(text=word))
        if part.text[-1:].isspace():
            words.append([])
    return [word for word in words if word]


def unescaped(text: str) -> str:
    """Return a text without the backslash before each character."""
    return re.sub(r"\\(.)", r"\1", text)


class _Reader:
    """A text that is read from left to right: each method returns where it ended, too."""

    def __init__(self, text: str) -> None:
        self._text = text

    def parts(self, at: int, of: re.Pattern[str], quote: str) -> tuple[list[Substitution], int]:
        """Read texts of a pattern and substitutions, as many as there are."""
        found: list[Substitution] = []
        while at < len(self._text):
            if self._text.startswith("$(", at):
                part, at = self._substitution(at, quote)
                found.append(part)
            elif (match := of.match(self._text, at)) is not None:
                found.append(TextSubstitution(text=unescaped(match[0])))
                at = match.end()
            else:
                break
        return found, at

    def _substitution(self, begin: int, quote: str) -> tuple[Substitution, int]:
        """Read `$(name ARGUMENT ...)`; within quotes, its arguments have none of that kind."""
        name = _NAME.match(self._text, begin + 2)
        if name is None:
            raise self._failure(begin, "a name is wanted after $(")
        at, arguments = name.end(), []
        while self._text.startswith(" ", at):
            argument, at = self._argument(at + 1, quote, begin)
            arguments.append(argument)
        if not self._text.startswith(")", at):
            raise self._failure(begin, "it has no )" if at == len(self._text) else self._odd(at))
        return self._made(name[0], arguments, begin), at + 1

    def _argument(self, at: int, quote: str, begin: int) -> tuple[list[Substitution], int]:
        own = self._text[at : at + 1]
        if quote or own not in _QUOTED:
            found, end = self.parts(at, _WORDS[quote], quote)
            if end == at:
                raise self._failure(begin, "one blank is wanted between its words")
            return found, end
        found, end = self.parts(at + 1, _QUOTED[own], own)
        if not self._text.startswith(own, end):
            raise self._failure(begin, f"its {own} is not closed")
        return found, end + 1

    def _made(self, name: str, arguments: list[list[Substitution]], begin: int) -> Substitution:
        if name in _OF_ANY_NUMBER:
            return _OF_ANY_NUMBER[name](*arguments)
        if name not in _SUBSTITUTIONS:
            near = nearest_hint(name, [*_SUBSTITUTIONS, *_OF_ANY_NUMBER])
            raise self._failure(begin, f"there is no substitution {name}{near}")
        make, takes = _SUBSTITUTIONS[name]
        needed, _, optional = takes.partition("|")
        names = [*needed.split(), *optional.split()]
        if not len(needed.split()) <= len(arguments) <= len(names):
            wanted = f"$({' '.join([name, *map(str.upper, names)])})"
            raise self._failure(begin, f"it is written {wanted}")
        values: dict[str, Any] = dict(zip(names, arguments, strict=False))
        if "python_modules" in values:  # `math, os`.
            modules = values["python_modules"]
            if not all(isinstance(part, TextSubstitution) for part in modules):
                raise self._failure(begin, "its modules are named by a text")
            names = "".join(part.text for part in modules).split(",") if modules else []
            values["python_modules"] = [name.strip() for name in names]
        made: Substitution = make(**values)
        return made

    def _odd(self, at: int) -> str:
        return f"{self._text[at]} is not expected: quote it, or write \\{self._text[at]}"

    def _failure(self, begin: int, why: str) -> SubstitutionFailure:
        return SubstitutionFailure(f"{self._text[begin:]}: {why}", calling_place())
