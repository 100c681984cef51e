"""The values of parameters: as text and back by the declared type, and which of them are secret."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from archo_tui.base.yaml_text.core_schema import YamlFault
from archo_tui.robot.messages.typed import MAX_LENGTH
from archo_tui.robot.messages.typed import parse as parse_typed
from archo_tui.robot.messages.values import checked, same, text_of
from archo_tui.robot.state.graph import MASK, Parameter

# The names of the numbers in rcl_interfaces/msg/ParameterType.
TYPES = {
    1: "bool", 2: "integer", 3: "double", 4: "string", 5: "byte[]",
    6: "bool[]", 7: "integer[]", 8: "double[]", 9: "string[]",
}  # fmt: skip

# The types of message fields that hold the same values.
_FIELDS = {"bool": "boolean", "integer": "int64", "double": "double", "string": "string"}
_FIELDS |= {f"{kind}[]": f"sequence<{of}>" for kind, of in _FIELDS.items()}


def as_python(message: Any) -> Any:
    """Return the value in a ParameterValue, with lists for arrays; None if it is not set."""
    kind = TYPES.get(message.type)
    if kind is None:
        return None
    value = getattr(message, value_field(kind))
    return list(value) if kind.endswith("[]") else value


def value_field(kind: str) -> str:
    """Return the field of rcl_interfaces/msg/ParameterValue that holds a type, such as `bool[]`."""
    return f"{kind.replace('[]', '_array')}_value"


def range_text(parameter: Parameter) -> str:
    """Return the allowed values of a parameter as text: `0.05 .. 2` or `read-only`; "" for any."""
    if parameter.read_only:
        return "read-only"
    if parameter.low is None or parameter.high is None:
        return ""
    return f"{_bound(parameter.low)} .. {_bound(parameter.high)}"


def _bound(value: float) -> str:
    """Return a number in its shortest form without losing a digit: `0.05`, `9999`, `1e+06`."""
    short = f"{value:g}"
    return short if float(short) == value else str(value)


def parse(parameter: Parameter, text: str) -> Any:
    """Return the value that a typed text means for a parameter; else raise ValueError in one line.

    A string is taken as it is typed, with blanks and without quotes. An array is a list in
    YAML.
    """
    if parameter.read_only:
        raise ValueError(f"{parameter.name} is read-only: it can only be set at startup")
    if len(text) > MAX_LENGTH:
        raise ValueError(f"too long: {len(text)} characters, at most {MAX_LENGTH}")
    if any(ord(char) < 32 or ord(char) == 127 for char in text):
        raise ValueError("control characters are not allowed")
    kind = parameter.type
    if kind not in _FIELDS:
        raise ValueError(f"a parameter of type {kind} cannot be edited here")
    if kind != "string" and not text.strip():
        raise ValueError(f"a value is needed ({kind})")
    try:
        value = parse_typed(_FIELDS[kind], text, of_parameter=True)
    except YamlFault:
        raise ValueError(f"not a list like [1, 2]: {text.strip()}") from None
    _check_range(parameter, value, text.strip())
    return value


def fit(parameter: Parameter, value: Any) -> Any:
    """Return a value from a file as a parameter takes it; else raise ValueError in one line."""
    if parameter.type == "double" and type(value) is int:
        value = float(value)
    if parameter.type == "double[]" and type(value) is list and all(type(v) is int for v in value):
        value = [float(item) for item in value]
    found = _type_of(value)
    if found != parameter.type and not (value == [] and parameter.type.endswith("[]")):
        raise ValueError(f"needs a value of type {parameter.type}, not {text_of(value)} ({found})")
    if parameter.read_only and not same(value, parameter.value):
        raise ValueError(f"read-only; its value is {text_of(parameter.value)}")
    _check_range(parameter, value, text_of(value))
    return checked(_FIELDS[parameter.type], value, "value")


def _type_of(value: Any) -> str:
    if isinstance(value, list):
        return f"{_type_of(value[0])}[]" if value else "an empty list"
    return {bool: "bool", int: "integer", float: "double", str: "string"}.get(type(value), "?")


def _check_range(parameter: Parameter, value: Any, text: str) -> None:
    """Raise an error if a number is outside the parameter's range; ROS has no ranges for lists."""
    if parameter.low is None or parameter.high is None or isinstance(value, list):
        return
    if not parameter.low <= value <= parameter.high:  # This form also refuses NaN.
        raise ValueError(f"allowed {range_text(parameter)}, not {text}")


# Secrets, by the name of the parameter.

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
