"""The Python class of an interface that the graph names."""

from __future__ import annotations

import importlib
from typing import Any


def load(type_name: str) -> Any:
    """The class of "package/kind/Name", or None when it is not installed here."""
    package, kind, name = type_name.split("/")
    try:
        return getattr(importlib.import_module(f"{package}.{kind}"), name)
    except (ImportError, AttributeError):
        return None
