"""Transforms as a table: what came in, and what is said of the frames."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from archo_tui.robot.state.frames import MOST_FRAMES, Frame, Transforms, faults, with_transforms
from archo_tui.text.graph import NONE, transform_lines

WALL = 1_000_000.0  # Unix time at the time 0 of the tests.


def transform(parent: str, child: str, stamp: float) -> Any:
    """A TransformStamped without its numbers."""
    time = SimpleNamespace(sec=int(stamp), nanosec=round(stamp % 1 * 1e9))
    header = SimpleNamespace(frame_id=parent, stamp=time)
    return SimpleNamespace(header=header, child_frame_id=child)


def heard(*came: tuple[float, str, str, float | None], simulated: bool = False) -> Transforms:
    """What came: when, parent, child and how old its stamp was; None for a static one."""
    frames: dict[str, Frame] = {}
    for now, parent, child, old in came:
        message = [transform(parent, child, WALL + now - (old or 0.0))]
        wall_time = None if simulated else WALL + now
        frames = with_transforms(frames, message, now, wall_time, is_static=old is None)
    return Transforms(frames, ("odometry",), ("state_publisher",))


ODOM = [(t / 10, "odom", "base_link", 0.1) for t in range(11)]  # At 10 Hz, the last at 1.0 s.
LASER = (0.0, "base_link", "laser", None)


def test_each_frame_tells_parent_rate_age_and_who_publishes_it() -> None:
    found = heard(*ODOM, LASER)
    assert transform_lines(found, 1.2) == [
        "base_link in odom: 10.0 Hz, 0.3 s old, from odometry",
        "laser in base_link: static, from state_publisher",
    ]
    several = found._replace(publishers=("amcl", "odometry"), static_publishers=())
    assert transform_lines(several, 1.2) == [
        "base_link in odom: 10.0 Hz, 0.3 s old, from one of amcl, odometry",
        "laser in base_link: static, its publisher has left",
    ]


def test_a_frame_falls_silent_unless_it_is_static() -> None:
    lines = transform_lines(heard(*ODOM, LASER), 61.0)
    assert lines == [
        "base_link in odom: SILENT for 60 s, from odometry",
        "laser in base_link: static, from state_publisher",
    ]


@pytest.mark.parametrize(
    ("came", "now", "said"),
    [
        ([*ODOM, LASER], 1.0, []),
        (
            [*ODOM, (1.0, "map", "base_link", 0.0)],
            1.0,
            ["base_link has 2 parents, map and odom: a frame has one"],
        ),
        ([*ODOM, (10.9, "map", "base_link", 0.0)], 12.0, []),  # Odometry has stopped by then.
        (
            [LASER, (20.0, "tower", "laser", 0.0)],
            20.0,
            ["laser has 2 parents, base_link and tower: a frame has one"],
        ),
        (
            [*ODOM, (1.0, "map", "dock", None)],
            1.0,
            ["the tree is in 2 parts, no transform joins them: base_link, odom; dock, map"],
        ),
        (
            [(0.0, "map", name, None) for name in "abcd"] + [(0.0, "e", "f", None)],
            0.0,
            ["the tree is in 2 parts, no transform joins them: a, b, c and 2 more; e, f"],
        ),
        (
            [(0.0, "odom", "base_link", -3.0)],
            0.0,
            ["the stamp of base_link is 3.0 s in the future: compare the clocks"],
        ),
        ([(0.0, "odom", "base_link", -0.2)], 0.0, []),
    ],
)
def test_what_is_wrong_is_said_in_words(came: Any, now: float, said: list[str]) -> None:
    assert list(faults(heard(*came), now)) == said
    assert transform_lines(heard(*came), now)[: len(said)] == [f"▲ {text}" for text in said]


def test_a_stamp_in_simulated_time_tells_no_age() -> None:
    found = heard((5.0, "odom", "base_link", WALL), simulated=True)
    assert found.frames["base_link"].age(5.5) == pytest.approx(0.5)
    assert list(faults(found, 5.5)) == []


def test_no_transforms_are_said_to_be_none_and_endless_ones_are_bounded() -> None:
    assert transform_lines(Transforms(), 0.0) == [NONE]
    waiting = Transforms(publishers=("odometry",))
    assert transform_lines(waiting, 0.0) == ["no transform came so far from odometry"]
    many = [transform("map", f"frame{n}", WALL) for n in range(MOST_FRAMES + 5)]
    assert len(with_transforms({}, many, 0.0, WALL, is_static=False)) == MOST_FRAMES
