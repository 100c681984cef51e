"""Which recording is meant, and which robot it is of."""

from __future__ import annotations

import os
from pathlib import Path

from archo_tui.errors import ArchoError
from archo_tui.paths import state_file
from archo_tui.recording import store
from archo_tui.replay.bag_file import BagFile
from archo_tui.robot_file import load
from archo_tui.robot_file.model import RobotFile

_MOST_FAULTS = 3  # that are said of one without a message


def path_of(given: str) -> Path:
    """Of a recording by its name, of a bag by its path; the newest recording where none is given.

    Raises ArchoError for what is neither.
    """
    folder = state_file("recordings")
    # os.path's is false, too, for names that are too long and folders that may not be looked into
    if given and (os.path.exists(given) or "/" in given):
        return Path(given)
    try:
        known = store.list_recordings(folder)
    except OSError as error:
        raise ArchoError(f"{error.filename}: {error.strerror}") from None
    if not known:
        raise ArchoError(f"no recordings in {folder}: name a bag by its path")
    if not given:
        return known[-1].folder
    for one in known:
        if one.name == given:
            return one.folder
    raise ArchoError(f"no recording is called {given} (see archo-tui recordings)")


def bag_of(given: str) -> BagFile:
    """What `path_of` says, opened. Raises ArchoError also for one without a message."""
    bag = BagFile(path_of(given))
    if not bag.counts:
        faults = "".join(f"; {fault}" for fault in bag.faults[:_MOST_FAULTS])
        raise ArchoError(f"{bag.path}: no message is in it{faults}")
    return bag


def robot_of(bag: BagFile, given: str) -> RobotFile:
    """As the file says that is given, else the recording itself; ARCHO where neither does."""
    if given:
        return load.load(Path(given))
    if bag.robot:
        return load.parse(bag.robot, bag.path / "robot.yaml")
    return load.load(load.default_path())
