"""The install() calls of a CMakeLists.txt, read as text: only those plainly written are found."""

from __future__ import annotations

import re
from typing import NamedTuple

from archo_tui.launch.package import Package

# `install(DIRECTORY launch config DESTINATION share/${PROJECT_NAME})`
_INSTALL = re.compile(
    r"install\s*\(\s*(DIRECTORY|FILES|PROGRAMS)\s+([^()]*?)\s+DESTINATION\s+([^\s()]+)"
    r"(?:\s+RENAME\s+([^\s()]+))?"
)


class Install(NamedTuple):
    """A call of `install()`."""

    kind: str  # DIRECTORY, FILES or PROGRAMS.
    names: tuple[str, ...]  # In the package's folder.
    destination: str  # Below the prefix.
    rename: str  # Of the only file; "" if it keeps its name.


def installs(package: Package) -> list[Install]:
    """Return what a package installs; nothing if it has no CMakeLists.txt."""
    file = package.folder / "CMakeLists.txt"
    try:
        text = file.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return []
    text = re.sub(r"#.*", "", text).replace("${PROJECT_NAME}", package.name)
    return [
        Install(kind, tuple(word.strip('"') for word in names.split()), folder.strip('"'), rename)
        for kind, names, folder, rename in _INSTALL.findall(text)
    ]


def scripts(package: Package) -> dict[str, str]:
    """Return the programs that are installed as they are, each by its name for `ros2 run`."""
    return {
        found.rename or name.rpartition("/")[2]: name
        for found in installs(package)
        if found.kind == "PROGRAMS" and found.destination.strip("/") == f"lib/{package.name}"
        for name in found.names
    }
