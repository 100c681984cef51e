"""Parameters whose names say that their values are secret, and what stands in place of a value."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from archo_tui import regular_files
from archo_tui.errors import ArchoError

MASK = "***"
_ALWAYS = ("password", "token", "secret", "apikey")  # also as the end of a word: `dbpassword`
_KEY = "key"  # secret as the last word of a part: `api_key`, and not `key_bindings`
_HUMP = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
_WORD = re.compile(r"[^\W\d_]+")


class SecretNames:
    """The rule that decides by the words of a parameter's name. Immutable; any thread."""

    def __init__(self, more: Iterable[str] = ()) -> None:
        """Begin with the built-in words.

        Args:
            more: Further words, as `pin`; several in one text are looked for side by side.
        """
        listed = (_words(text) for text in more)
        self._listed = [words for words in listed if words]

    def fit(self, name: str) -> bool:
        """Return True for the name of a secret: `wifi.password`, `apiKey`, `auth_tokens`."""
        words = _words(name)
        return (
            any(word.endswith(_ALWAYS) for word in words)
            or any(_holds(words, listed) for listed in self._listed)
            or any(_words(part)[-1:] == [_KEY] for part in name.split("."))
        )

    def masked(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return values by name, with MASK in place of the secret ones."""
        return {name: MASK if self.fit(name) else value for name, value in values.items()}

    def without(self, text: str, values: Mapping[str, Any]) -> str:
        """Return a text with MASK in place of each secret text among `values` that it quotes."""
        for name, value in values.items():
            if isinstance(value, str) and value and self.fit(name):
                text = text.replace(value, MASK)
        return text


def load(path: Path) -> SecretNames:
    """Read further words, one or several side by side a line; `#` begins a comment.

    Raises:
        ArchoError: The file is there and cannot be read: its secrets would be shown.
    """
    try:
        text = regular_files.read(path).decode("utf-8-sig")
    except (FileNotFoundError, NotADirectoryError):  # also where no home folder is known
        return SecretNames()
    except OSError as error:
        raise ArchoError(f"{path}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise ArchoError(f"{path}: not UTF-8") from None
    return SecretNames(line.partition("#")[0] for line in text.splitlines())


def _words(name: str) -> list[str]:
    """Return the words of a name in lower case and singular: `apiKeys2` is `api`, `key`."""
    return [word.casefold().removesuffix("s") for word in _WORD.findall(_HUMP.sub(" ", name))]


def _holds(words: Sequence[str], listed: Sequence[str]) -> bool:
    ends = range(len(listed), len(words) + 1)
    return any(words[end - len(listed) : end] == listed for end in ends)
