"""The recording that a command line means, and the robot file for it."""

from __future__ import annotations

import os
from pathlib import Path

from archo_tui.clock import Clock
from archo_tui.errors import ArchoError
from archo_tui.paths import state_file
from archo_tui.recording import store
from archo_tui.recording.bag import read_info
from archo_tui.replay.bag_file import BagFile
from archo_tui.replay.player import Player
from archo_tui.robot_file import load
from archo_tui.robot_file.model import RobotFile

BEFORE_MARK = 5.0  # Seconds.
_MAX_FAULTS = 3  # In the error for a bag without a message.


def find_recording(given: str) -> Path:
    """Return the path of a recording.

    Args:
        given: A bag's path or a recording's name; an existing path goes before a name, and one with
            a `/` is returned unchecked. "" means the newest recording.

    Raises:
        ArchoError: There is no such recording, or the folder of recordings cannot be read.
    """
    folder = state_file("recordings")
    # Unlike Path.exists, os.path.exists returns False for names that are too long.
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
    for recording in known:
        if recording.name == given:
            return recording.folder
    raise ArchoError(f"no recording is called {given} (see archo-tui recordings)")


def open_bag(given: str) -> BagFile:
    """Open the bag that `find_recording` finds.

    Raises:
        ArchoError: There is no such recording, it is no bag that can be read, or has no message.
    """
    bag = BagFile(find_recording(given))
    if not bag.count:
        faults = "".join(f"; {fault}" for fault in bag.faults[:_MAX_FAULTS])
        raise ArchoError(f"{bag.path}: no message is in it{faults}")
    return bag


def opening_time(path: Path, start: float) -> float:
    """Return the Unix time at which the replay of a bag opens: 5 s before its first trigger.

    Args:
        path: The bag.
        start: Unix time of its first message, in s: the earliest that is returned, and the result
            for a bag whose trigger is unknown.
    """
    try:
        at = read_info(path).at
    except (OSError, ValueError):  # Another tool's bag, or a single file.
        at = None
    return start if at is None else max(at - BEFORE_MARK, start)


def load_robot_file(bag: BagFile, given: str) -> RobotFile:
    """Return the robot of a bag: the given one, else the one attached to the bag, else ARCHO.

    Args:
        bag: The bag.
        given: The path of a robot file; "" for none.

    Raises:
        ArchoError: The robot file cannot be read or is not valid.
    """
    if given:
        return load.load(Path(given))
    if bag.robot:
        return load.parse(bag.robot, bag.path / "robot.yaml")
    return load.load(load.default_path())


def make_player(bag: BagFile, robot: RobotFile, clock: Clock) -> Player:
    """Return the player of a bag, paused at its `opening_time`.

    It reads the disk, so a console that runs calls it on another thread.
    """
    player = Player(bag, robot, clock)
    player.go_to(opening_time(bag.path, bag.start))
    return player
