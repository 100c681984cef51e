"""Places and lists of goals under a name: of the robot file, and of the user's own."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from archo_tui.base.errors import ArchoError
from archo_tui.base.paths import config_file
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot_file import load
from archo_tui.robot_file.model import FormField
from archo_tui.screen.commands import registry
from archo_tui.station.places import Places
from archo_tui.verbs.places import pose_goal
from archo_tui.verbs.verb import NotPossible
from tests.support.archo import ARCHO, SHELF
from tests.support.console import FAST, LONG, console
from tests.support.plain import operated, plain
from tests.support.quiet import until

PLACES = """
places:
  - {name: dock, values: {shelf_number: 1}}
  - {name: far, values: {shelf_number: 99}}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """ARCHO's robot file with two places."""
    path = tmp_path / "robot.yaml"
    path.write_text(load.default_path().read_text(encoding="utf-8") + PLACES)
    return path


async def test_a_place_is_a_goal_and_no_other_word_is(file: Path) -> None:
    code, said = await plain("go dock 2\ngo dok\ngo far\ngo 3 nan\n", robot=file, ros_args=FAST)
    assert code == 1
    assert "goal ARRIVED, Arrived at shelf 1" in said
    assert "goal ARRIVED, Arrived at shelf 2" in said
    assert "failed: go: no place dok (nearest: dock)" in said
    assert "failed: go: Shelf: at most 40, not 99" in said
    assert "failed: go: Shelf: not a whole number: nan" in said  # nan is the name of no place
    assert "shelf 3" not in said
    code, said = await plain("go dock\n", ros_args=FAST)  # A robot without places.
    assert (code, "failed: go: Shelf: not a whole number: dock" in said) == (1, True)


async def test_what_is_saved_under_a_name_is_there_for_the_next_console(file: Path) -> None:
    config_file("places.yaml").unlink(missing_ok=True)
    lines = "save_place mine 7\nsave_place dock 3\nsave_place 5 3\nsave_place two 1 2\nplaces\n"
    _, said = await plain(lines, robot=file, ros_args=FAST)
    assert "YOU console: place mine: saved as 7" in said
    assert "failed: save_place: dock is a place of the robot file" in said
    assert "failed: save_place: '5' is no name" in said
    assert "failed: save_place: a place is one goal" in said
    assert "dock: shelf 1\nfar: shelf 99\nmine: shelf 7\n" in said
    async with operated(robot=file, ros_args=FAST) as person:
        await person.enter("go mine", "Arrived at shelf 7")
        path = config_file("places.yaml")
        path.write_text(path.read_text().replace("shelf_number: 7", "shelf_number: 5"))
        await person.enter("go mine", "Arrived at shelf 5")  # The file's, changed meanwhile.


async def test_a_queue_that_was_saved_is_driven_again_and_held_by_a_stop(
    file: Path,
) -> None:
    config_file("places.yaml").unlink(missing_ok=True)
    async with operated(robot=file, ros_args=LONG) as person:
        station = person.station
        person.type("go 12 7 3\nsave_queue round\nskip\nskip\n")
        await until(lambda: "round" in station.places.lists and not station.queue.waiting)
        await person.enter("stop", "STOP: confirmed")
        await person.enter("release --yes", "release stop: ")
        person.type("go_list round 2\n")
        await until(lambda: len(station.queue.waiting) == 5)
        assert [goal.text for goal in station.queue.waiting] == ["7", "3", "12", "7", "3"]
        person.type("stop\n")
        await until(lambda: station.queue.hold_reason == "STOP")
        person.type("release --yes\nplaces\n")
        await person.until("round: a list of 3 goals")
        await until(lambda: not station.robot.snapshot.is_stopped)
        assert station.running_goal is None
        assert len(station.queue.waiting) == 5  # It never goes on by itself.
        person.type("go_list round 0\ngo_list rund\ngo_list round 1000\n")
        await person.until("failed: go_list: how often: from 1 to 1000, not 0")
        await person.until("failed: go_list: no list rund (nearest: round)")
        await person.until("failed: go_list: more than 1000 goals would wait")


async def test_places_stand_in_the_palette(file: Path) -> None:
    async with console(*FAST, robot=file) as op:
        await op.press("ctrl+p")
        await op.type("dock")
        await op.until("Go to dock")
        await op.press("enter")
        await op.until("Arrived at shelf 1")


@pytest.mark.parametrize(
    "text",
    [
        "- 1",
        "ARCHO: {places: [dock]}",
        "ARCHO: {places: {dock: {goal: shelf}}}",
        "ARCHO: {places: {dock: {goal: shelf, values: {shelf: 3}}}}",
        "ARCHO: {lists: {a: {goal: shelf}}}",
        "ARCHO: {places: {dock: {goal: nothere, values: abc}}}",
        "ARCHO: {places: {'1': {goal: shelf, values: {shelf_number: 1}}}}",
        "ARCHO: [",
    ],
)
def test_a_file_that_is_none_is_said_and_never_written_over(text: str, tmp_path: Path) -> None:
    path = tmp_path / "places.yaml"
    path.write_text(text)
    places = Places(ARCHO, path)
    places.load()
    assert str(path) in places.fault
    assert places.all == []
    with pytest.raises(ArchoError):
        places.save_place("dock", SHELF, {"shelf_number": 1})
    assert path.read_text() == text


def test_two_consoles_and_two_robots_keep_each_others_places(tmp_path: Path) -> None:
    path = tmp_path / "places.yaml"
    others = {"places": {"home": {"goal": "x", "values": {"y": 1}}}, "of_a_later_version": ["z"]}
    path.write_text(f"other: {json.dumps(others)}\n")
    one, two = Places(ARCHO, path), Places(ARCHO, path)
    one.save_place("a", SHELF, {"shelf_number": 1})
    two.save_list("b", [QueuedGoal(SHELF, {"shelf_number": 2})])
    three = Places(ARCHO, path)
    three.load()
    assert three.of(SHELF) == {"a": {"shelf_number": 1}}
    assert [goal.values for goal in three.goals("b")] == [{"shelf_number": 2}]
    assert yaml.safe_load(path.read_text())["other"] == others


def test_the_palette_saves_the_pose_only_for_a_goal_that_is_one() -> None:
    pose = replace(SHELF, id="pose", form={"x": FormField(), "pose.y": FormField()})
    for goals, offered in (((SHELF,), False), ((SHELF, pose), True), ((), False)):
        commands = registry(replace(ARCHO, goals=goals))
        assert any("save_place" in command.verbs for command in commands) is offered
    with pytest.raises(NotPossible, match="Shelf is no part of a pose"):
        pose_goal(SHELF, {"x": 1.0, "y": 2.0, "yaw": 0.0})


def test_a_place_that_could_not_be_written_is_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    places = Places(ARCHO, tmp_path / "places.yaml")
    places.save_place("a", SHELF, {"shelf_number": 1})

    def refuse(*_: object) -> None:
        raise ArchoError("the disk is full")

    monkeypatch.setattr("archo_tui.station.places.write_atomically", refuse)
    with pytest.raises(ArchoError, match="the disk is full"):
        places.save_place("a", SHELF, {"shelf_number": 7})
    assert places.find(SHELF, "a") == {"shelf_number": 1}


def test_an_own_place_gives_way_to_one_of_the_robot_file(file: Path, tmp_path: Path) -> None:
    path = tmp_path / "places.yaml"
    path.write_text("")
    places = Places(load.load(file), path)
    places.load()
    assert places.fault == ""
    own = "ARCHO: {places: {dock: {goal: shelf, values: {shelf_number: 9}}, "
    path.write_text(f"{own}x: {{goal: shelf, values: {{shelf_number: 2}}}}}}}}")
    places.load()
    assert places.fault == ""
    assert places.find(SHELF, "dock") == {"shelf_number": 1}
    assert places.find(SHELF, "x") == {"shelf_number": 2}
