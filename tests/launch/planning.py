"""The workspace that the tests share."""

from __future__ import annotations

from pathlib import Path

WORKSPACE = Path(__file__).parent.parent / "share" / "workspace"
