"""A package of a workspace, as its package.xml names it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from archo_tui import regular_files
from archo_tui.errors import ArchoError
from archo_tui.ros_names import KINDS

AMENT_PYTHON = "ament_python"
_WITHOUT_EXPORT = "catkin"  # What REP 149 takes where package.xml has no build_type.


@dataclass(frozen=True)
class Package:
    """A package in its source folder."""

    name: str
    folder: Path  # Of its package.xml.
    build_type: str  # `ament_python`, `ament_cmake`, ...; `catkin` if package.xml names none.

    @property
    def has_interfaces(self) -> bool:
        """True if the package has a folder msg/, srv/ or action/."""
        return any((self.folder / kind).is_dir() for kind in KINDS)


def read_package(folder: Path) -> Package:
    """Return the package of a folder; raise ArchoError with file and line."""
    file = folder / "package.xml"
    try:
        root = ElementTree.fromstring(regular_files.read(file))
    except OSError as error:
        raise ArchoError(f"{file}: {error.strerror}") from None
    except ElementTree.ParseError as error:
        raise ArchoError(f"{file}:{error.position[0]}: not XML: {error}") from None
    except (LookupError, ValueError):  # As for `encoding="none such"`.
        raise ArchoError(f"{file}:1: not XML: its encoding is not known") from None
    name = (root.findtext("name") or "").strip()
    if not name:
        raise ArchoError(f"{file}:1: no <name>: it names the package, <name>my_package</name>")
    build_type = (root.findtext("export/build_type") or _WITHOUT_EXPORT).strip()
    return Package(name, folder, build_type)
