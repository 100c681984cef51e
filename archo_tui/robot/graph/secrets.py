"""The rule for which parameters are secret by their names, and the masking of their values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from rcl_interfaces.msg import Parameter, ParameterEvent, ParameterType, ParameterValue

from archo_tui.robot.state.graph import MASK

_ALWAYS = ("password", "token", "secret", "apikey")  # Also at the end of a word: `dbpassword`.
_KEY = "key"  # Secret only as the last word of a part: `api_key`, but not `key_bindings`.
_HUMP = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")
_WORD = re.compile(r"[^\W\d_]+")


def is_secret(name: str) -> bool:
    """Return True for a secret parameter, such as `wifi.password`, `apiKey` or `auth_tokens`."""
    return any(word.endswith(_ALWAYS) for word in _words(name)) or any(
        _words(part)[-1:] == [_KEY] for part in name.split(".")
    )


def masked(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of values by name, with MASK in place of the secret ones."""
    return {name: MASK if is_secret(name) else value for name, value in values.items()}


def masked_text(text: str, values: Mapping[str, Any]) -> str:
    """Return a text, such as the reason for a refusal, with MASK in place of secrets it quotes."""
    for name, value in values.items():
        if isinstance(value, str) and value and is_secret(name):
            text = text.replace(value, MASK)
    return text


def _words(name: str) -> list[str]:
    """Return the words of a name in lower case and singular: `apiKeys2` is `api`, `key`."""
    return [word.casefold().removesuffix("s") for word in _WORD.findall(_HUMP.sub(" ", name))]


def without_secrets(message: ParameterEvent) -> ParameterEvent:
    """Return a message with MASK in place of secret values; the same object if it has none."""
    parts = (message.new_parameters, message.changed_parameters, message.deleted_parameters)
    if not any(is_secret(parameter.name) for part in parts for parameter in part):
        return message
    hidden = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=MASK)
    new, changed, deleted = (
        [
            Parameter(name=parameter.name, value=hidden) if is_secret(parameter.name) else parameter
            for parameter in part
        ]
        for part in parts
    )
    return ParameterEvent(
        stamp=message.stamp,
        node=message.node,
        new_parameters=new,
        changed_parameters=changed,
        deleted_parameters=deleted,
    )
