"""What a client costs: the standard library, and little more than `import socket, json`."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import pytest

# The console's own rules that a client shares; none of them imports a library.
OURS = (
    *("archo_tui", "archo_tui.client", "archo_tui.base", "archo_tui.base.errors"),
    *("archo_tui.base.nearest",),
    *("archo_tui.base.safe_text", "archo_tui.base.surrogates", "archo_tui.robot_file"),
    *("archo_tui.robot_file.reserved", "archo_tui.robot", "archo_tui.robot.stop"),
    "archo_tui.robot.stop.words",
)


def loaded(statement: str) -> set[str]:
    """The modules that Python has after a statement, site's own not counted."""
    code = f"import sys; before = set(sys.modules); {statement}; print(*set(sys.modules) - before)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    return set(done.stdout.split())


@pytest.mark.parametrize(
    ("module", "most"),
    [("shell", 23), ("find", 16), ("protocol", 12), ("robot", 45)],
)
def test_a_client_loads_few_modules_beside_socket_and_json(module: str, most: int) -> None:
    name = f"archo_tui.client.{module}"
    found: Any = loaded(f"import {name}") - loaded("import socket, json")
    own = {other for other in found if other.startswith("archo_tui")}
    strange = {other for other in own if not other.startswith("archo_tui.client.")} - {*OURS}
    assert strange == set()  # nothing of the console
    others = {other.partition(".")[0].lstrip("_") for other in found - own}
    assert others <= {*(std.lstrip("_") for std in sys.stdlib_module_names)}
    assert len(found) <= most, sorted(found)
