"""The recording that a command line means, the robot file for it, and its player."""

from __future__ import annotations

import os
from pathlib import Path

from archo_tui.clock import Clock
from archo_tui.errors import ArchoError
from archo_tui.paths import state_file
from archo_tui.recordings import store
from archo_tui.recordings.replay.bag import BagFile
from archo_tui.recordings.replay.player import Player
from archo_tui.robot_file import load
from archo_tui.robot_file.model import RobotFile

_BEFORE_MARK = 5.0  # Seconds.
_MAX_FAULTS = 3  # In the error for a bag without a message.


def find_recording(given: str) -> Path:
    """Return the path of a recording: an existing path, a name, or for "" the newest.

    A path with a `/` is returned unchecked.
    """
    # Unlike Path.exists, os.path.exists returns False for names that are too long.
    if given and (os.path.exists(given) or "/" in given):
        return Path(given)
    known = store.own_recordings()
    if not known:
        raise ArchoError(f"no recordings in {state_file('recordings')}: name a bag by its path")
    for recording in known:
        if given in ("", recording.name):
            return recording.folder
    raise ArchoError(f"no recording is called {given} (see archo-tui recordings)")


def open_bag(given: str) -> BagFile:
    """Open the bag that `find_recording` finds; raise ArchoError if no message can be in it."""
    bag = BagFile(find_recording(given))
    if not bag.count:
        faults = "".join(f"; {fault}" for fault in bag.faults[:_MAX_FAULTS])
        raise ArchoError(f"{bag.path}: no message is in it{faults}")
    return bag


def opening_time(path: Path, start: float) -> float:
    """Return the Unix time at which a replay opens: 5 s before the trigger, if that is known."""
    try:
        at = store.read_recording(path).at
    except (OSError, ValueError):  # Another tool's bag, or a single file.
        at = None
    return start if at is None else max(at - _BEFORE_MARK, start)


def load_robot_file(bag: BagFile, given: str) -> RobotFile:
    """Return the robot of a bag: the file given, else the one attached to the bag, else ARCHO."""
    if given:
        return load.load(Path(given))
    if bag.robot:
        return load.parse(bag.robot, bag.path / "robot.yaml")
    return load.load(load.default_path())


def make_player(bag: BagFile, robot: RobotFile, clock: Clock) -> Player:
    """Return the player of a bag, paused at its `opening_time`; it reads the disk."""
    player = Player(bag, robot, clock)
    player.go_to(opening_time(bag.path, bag.start))
    return player
