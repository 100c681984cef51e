"""Texts with `$(name ARGUMENT ...)` in them, as XML and YAML launch files write substitutions."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from dataclasses import MISSING, fields
from typing import Any

from archo_tui.launch.stand_ins import substitutions
from archo_tui.launch.stand_ins.absent import absent_class
from archo_tui.launch.stand_ins.core import (
    Substitution,
    SubstitutionFailure,
    TextSubstitution,
    calling_place,
)
from archo_tui.launch.stand_ins.packages import FindPackagePrefix, FindPackageShare
from archo_tui.nearest import nearest_hint

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")
_DOLLAR = r"\$(?!\()|(?<=\\)\$"  # One that begins no substitution.
_TEXT = re.compile(rf"(?:[^$]|{_DOLLAR})+")
_QUOTED = {quote: re.compile(rf"(?:[^$\\{quote}]|{_DOLLAR}|\\{quote}?)+") for quote in "'\""}
_WORDS = {  # An argument that is not quoted itself, by the quotes around the substitution.
    quote: re.compile(rf"(?:[^ $()\\{own}]|{_DOLLAR}|\\[(){own}]?)+")
    for quote, own in (("", "'\""), ("'", "'"), ('"', '"'))
}

_ABSENT = {
    "command": ("launch.substitutions", "Command"),
    "exec-in-pkg": ("launch_ros.substitutions", "ExecutableInPackage"),
    "find-exec": ("launch.substitutions", "FindExecutable"),
    "launch_log_dir": ("launch.substitutions", "LaunchLogDir"),
    "log_dir": ("launch.substitutions", "LaunchLogDir"),
}
# Each substitution by its name; its arguments are the fields of the class.
_SUBSTITUTIONS: dict[str, Any] = {
    **{name: absent_class(*given) for name, given in _ABSENT.items()},
    "all": substitutions.AllSubstitution,
    "and": substitutions.AndSubstitution,
    "anon": substitutions.AnonName,
    "any": substitutions.AnySubstitution,
    "dirname": substitutions.ThisLaunchFileDir,
    "env": substitutions.EnvironmentVariable,
    "equals": substitutions.EqualsSubstitution,
    "eval": substitutions.PythonExpression,
    "file-content": substitutions.FileContent,
    "filename": substitutions.ThisLaunchFile,
    "find-pkg-prefix": FindPackagePrefix,
    "find-pkg-share": FindPackageShare,
    "if": substitutions.IfElseSubstitution,
    "not": substitutions.NotSubstitution,
    "not-equals": substitutions.NotEqualsSubstitution,
    "or": substitutions.OrSubstitution,
    "var": substitutions.LaunchConfiguration,
}
_OF_ANY_NUMBER = (*_ABSENT, "all", "any")


def substitutions_in(text: str) -> list[Substitution]:
    """Return the substitutions of a text, and the texts between them; raise SubstitutionFailure."""
    return _Reader(text).parts(0, _TEXT, "")[0] or [TextSubstitution(text="")]


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
            odd = self._text[at : at + 1]
            why = f"{odd} is not expected: quote it, or write \\{odd}" if odd else "it has no )"
            raise self._failure(begin, why)
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
        if name not in _SUBSTITUTIONS:
            near = nearest_hint(name, _SUBSTITUTIONS)
            raise self._failure(begin, f"there is no substitution {name}{near}")
        make: Callable[..., Substitution] = _SUBSTITUTIONS[name]
        if name in _OF_ANY_NUMBER:
            return make(*arguments)
        takes = fields(_SUBSTITUTIONS[name])
        needed = [field for field in takes if field.default is MISSING]
        if not len(needed) <= len(arguments) <= len(takes):
            wanted = " ".join([name, *(field.name.upper() for field in takes)])
            raise self._failure(begin, f"it is written $({wanted})")
        given = zip(takes, arguments, strict=False)
        return make(**{field.name: argument for field, argument in given})

    def _failure(self, begin: int, why: str) -> SubstitutionFailure:
        return SubstitutionFailure(f"{self._text[begin:]}: {why}", calling_place())
