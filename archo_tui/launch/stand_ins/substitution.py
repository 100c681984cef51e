"""The base of substitutions: texts that are computed when a launch file is evaluated."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

from archo_tui.launch.stand_ins.context import LaunchContext
from archo_tui.launch.stand_ins.places import calling_place

SomeSubstitutionsType = Any  # A text, a substitution, or several of them that are joined.


class Substitution:
    """The base of all substitutions: each stands for a text."""

    def __init__(self) -> None:
        self.place = calling_place()

    def perform(self, context: LaunchContext) -> str:
        """Return the text that the substitution stands for now; SubstitutionFailure without one."""
        raise NotImplementedError

    def describe(self) -> str:
        """Return the substitution as `--show-args` shows a default."""
        return type(self).__name__


class TextSubstitution(Substitution):
    """A text that stands for itself."""

    def __init__(self, *, text: str) -> None:
        super().__init__()
        if not isinstance(text, str):
            raise TypeError(f"TextSubstitution takes a text, not {text!r}")
        self.text = text

    def perform(self, context: LaunchContext) -> str:
        return self.text

    def describe(self) -> str:
        return self.text


def normalize_to_list_of_substitutions(given: SomeSubstitutionsType) -> list[Substitution]:
    """Return a text, a path, a substitution, or several of them, as a list of substitutions."""
    if isinstance(given, (str, os.PathLike, Substitution)):
        return [_part(given)]
    if isinstance(given, Iterable):
        return [_part(part) for part in given]
    raise TypeError(_wanted(given))


def _part(given: object) -> Substitution:
    if isinstance(given, Substitution):
        return given
    if isinstance(given, (str, os.PathLike)):
        return TextSubstitution(text=os.fspath(given))
    raise TypeError(_wanted(given))


def _wanted(given: object) -> str:
    is_plain = isinstance(given, (bool, int, float))
    hint = f": write '{str(given).lower() if isinstance(given, bool) else given}'"
    kind = type(given).__name__
    return f"a text or a substitution is wanted, not {kind} {given!r}{hint if is_plain else ''}"


def perform_substitutions(context: LaunchContext, parts: Iterable[Substitution]) -> str:
    """Return the texts of several substitutions, joined."""
    return "".join([context.perform_substitution(part) for part in parts])


def perform(context: LaunchContext, given: SomeSubstitutionsType) -> str:
    """Return the text of what a launch file gives: a text, a substitution, or a list of them."""
    return perform_substitutions(context, normalize_to_list_of_substitutions(given))


def is_substitution(given: object) -> bool:
    """Return True for a substitution, or a list with one; a list of texts alone is none."""
    if isinstance(given, Substitution):
        return True
    if isinstance(given, str) or not isinstance(given, Iterable):
        return False
    parts = list(given)
    of_text = all(isinstance(part, (Substitution, str)) for part in parts)
    return of_text and any(isinstance(part, Substitution) for part in parts)
