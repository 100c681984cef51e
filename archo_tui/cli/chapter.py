"""The subcommand `chapter`, which writes the files that a reader of the textbook starts from."""

from __future__ import annotations

import shlex
import shutil
from argparse import Namespace
from pathlib import Path

from archo_tui.errors import ArchoError
from archo_tui.safe_text import safe

_PACKAGE = Path(__file__).parents[1]
_INTERFACES = ("CMakeLists.txt", "package.xml", "msg", "srv", "action")
_NEXT = """\
See them:     archo-tui --node {workspace} --only
Launch them:  archo-tui launch {workspace} use_sim:=true
Check them:   archo-tui check {workspace}
On ROS 2:     cd {workspace} && colcon build"""


def write_chapter(options: Namespace) -> int:
    """Write a workspace with the chapter's nodes, launch file, parameters and interfaces.

    Raises ArchoError, and writes nothing, if one of the files is there.
    """
    if not options.folder.strip():
        raise ArchoError("type the name of a folder")
    workspace = Path(options.folder)
    files = {workspace / name: source for name, source in _sources().items()}
    if there := next((path for path in files if path.exists() or path.is_symlink()), None):
        raise ArchoError(f"{there} is there already: nothing was written; name another folder")
    try:
        for path, source in files.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, path)
    except OSError as error:
        raise ArchoError(f"{error.filename or workspace}: not written: {error.strerror}") from None
    for line in [
        *map(str, files),
        *_NEXT.format(workspace=shlex.quote(str(workspace))).split("\n"),
    ]:
        print(safe(line))
    return 0


def _sources() -> dict[Path, Path]:
    """Return the file to copy for each path below the workspace."""
    in_clone = (_PACKAGE.parent / "interfaces" / "package.xml").is_file()
    root = _PACKAGE.parent if in_clone else _PACKAGE
    interfaces = root / ("interfaces" if in_clone else "embedded/share/archo_interfaces")
    chapter = root / "config" / "chapter"
    found = {path.relative_to(chapter): path for path in sorted(chapter.rglob("*"))}
    for name in _INTERFACES:
        path = interfaces / name
        for file in [path] if path.is_file() else sorted(path.iterdir()):
            found["src/archo_interfaces" / file.relative_to(interfaces)] = file
    return {
        name: path
        for name, path in found.items()
        if path.is_file() and "__pycache__" not in name.parts
    }
