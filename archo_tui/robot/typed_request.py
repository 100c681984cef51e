"""The parsing of the request behind `call SERVICE`, for a service of the robot file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from archo_tui.robot import forms
from archo_tui.robot.state import TypedField
from archo_tui.robot_file.model import Scalar
from archo_tui.yaml_text import bounded_yaml
from archo_tui.yaml_text.core_schema import YamlFault

Request = Mapping[str, Scalar]  # The values of a request by field, as in the robot file.
_TYPES = {bool: "boolean", int: "int64", float: "double", str: "string"}


def mapping(text: str) -> dict[str, Any]:
    """Return the values in a YAML mapping `{field: value, ...}`, nested ones included.

    Raises:
        ValueError: The text is not YAML within our limits, or no mapping.
    """
    try:
        values = bounded_yaml.load(text)
    except YamlFault as fault:
        raise ValueError(str(fault)) from None
    if not isinstance(values, dict):
        raise ValueError("expected {field: value, ...}")
    return values


def typed_request(service: str, words: Sequence[str], form: Request) -> dict[str, Any]:
    """Return the values of a request that was typed as `field=value ...` or as one YAML mapping.

    Fields that were not typed are left out.

    Args:
        service: The name of the service, for errors.
        words: The words behind the service.
        form: An example of a request, which has the fields and their types.

    Raises:
        ValueError: A field is not in the form, is given twice, or has a value of another type; or
            the one word is no YAML mapping.
    """
    fields = [TypedField(name, _TYPES[type(example)], None) for name, example in form.items()]
    if len(words) == 1 and words[0].startswith("{"):
        words = [f"{name}={value}" for name, value in mapping(words[0]).items()]
    try:
        texts = forms.texts_by_path(fields, {}, words, partial=True)
    except ValueError as error:
        raise ValueError(f"{service}: {error}") from None
    return forms.parse_all(fields, {}, texts)


def as_typed(request: Request) -> str:
    """Return a request of the robot file as an operator types it: `a=true b=2`; texts unquoted."""
    texts = {name: str(v).lower() if isinstance(v, bool) else v for name, v in request.items()}
    return " ".join(f"{name}={text}" for name, text in texts.items())
