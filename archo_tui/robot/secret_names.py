"""The rule for which parameters are secret by their names, and the masking of their values."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from archo_tui import regular_files
from archo_tui.errors import ArchoError

MASK = "***"
_ALWAYS = ("password", "token", "secret", "apikey")  # Also at the end of a word: `dbpassword`.
_KEY = "key"  # Secret only as the last word of a part: `api_key`, but not `key_bindings`.
_HUMP = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
_WORD = re.compile(r"[^\W\d_]+")


class SecretNames:
    """The rule by which a parameter's name makes it secret. Immutable; any thread may use it."""

    def __init__(self, more: Iterable[str] = ()) -> None:
        """Create a rule with the built-in words, such as `password` and `token`, and further ones.

        Args:
            more: The further words, such as `pin`; several words in one text must be side by side.
        """
        listed = (_words(text) for text in more)
        self._listed = [words for words in listed if words]

    def matches(self, name: str) -> bool:
        """Return True for a secret name, such as `wifi.password`, `apiKey` or `auth_tokens`.

        Upper case and a plural `s` make no difference. `key` counts only at the end of the name or
        of a part before a dot: `key_bindings` is not secret.
        """
        words = _words(name)
        return (
            any(word.endswith(_ALWAYS) for word in words)
            or any(_contains_phrase(words, listed) for listed in self._listed)
            or any(_words(part)[-1:] == [_KEY] for part in name.split("."))
        )

    def masked(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return a copy of values by name, with MASK in place of those whose name is secret."""
        return {name: MASK if self.matches(name) else value for name, value in values.items()}

    def masked_text(self, text: str, values: Mapping[str, Any]) -> str:
        """Return a text with MASK in place of each secret value that it quotes.

        Args:
            text: The text, such as a node's reason for a refusal.
            values: Values by name. Only strings whose name is secret are masked.
        """
        for name, value in values.items():
            if isinstance(value, str) and value and self.matches(name):
                text = text.replace(value, MASK)
        return text


def load(path: Path) -> SecretNames:
    """Return the rule with the further words in a file, one text a line; `#` begins a comment.

    If the file does not exist, only the built-in words make a name secret.

    Raises:
        ArchoError: The file exists and cannot be read, so secrets might be shown.
    """
    try:
        text = regular_files.read(path).decode("utf-8-sig")
    except (FileNotFoundError, NotADirectoryError):  # Also if no home folder is known.
        return SecretNames()
    except OSError as error:
        raise ArchoError(f"{path}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise ArchoError(f"{path}: not UTF-8") from None
    return SecretNames(line.partition("#")[0] for line in text.splitlines())


def _words(name: str) -> list[str]:
    """Return the words of a name in lower case and singular: `apiKeys2` is `api`, `key`."""
    return [word.casefold().removesuffix("s") for word in _WORD.findall(_HUMP.sub(" ", name))]


def _contains_phrase(words: Sequence[str], listed: Sequence[str]) -> bool:
    """Return True if `words` contain the `listed` words side by side and in order."""
    ends = range(len(listed), len(words) + 1)
    return any(words[end - len(listed) : end] == listed for end in ends)
