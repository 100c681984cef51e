"""The pure behaviour beside the nodes."""

from __future__ import annotations

import pytest
from archo_bringup import battery_model, motion

pytestmark = pytest.mark.pure


def test_the_charge_stays_between_empty_and_full() -> None:
    assert battery_model.changed(1.0, -2.0) == 0.0
    assert battery_model.changed(99.5, 2.0) == 100.0
    assert battery_model.changed(50.0, -0.5) == 49.5


@pytest.mark.parametrize(
    ("percentage", "before", "after"),
    [
        (20.0, "good", "good"),
        (19.9, "good", "warning"),
        (20.1, "warning", "warning"),
        (22.9, "warning", "warning"),
        (23.0, "warning", "good"),
    ],
)
def test_a_low_battery_warns_at_twenty_and_clears_at_twenty_three(
    percentage: float, before: str, after: str
) -> None:
    assert battery_model.health(percentage, 20.0, before) == after


def test_a_threshold_near_full_can_still_clear() -> None:
    assert battery_model.health(100.0, 99.0, "warning") == "good"


def test_ticks_grow_with_the_way_driven_and_not_beyond_the_end() -> None:
    drive = motion.Drive()
    drive.begin(1.0)
    per_metre = motion.ticks_per_metre(0.05, 1024)
    assert per_metre == pytest.approx(3259.493)
    assert drive.advance(5.0, per_metre)
    assert drive.encoder_ticks == 15420 + 3259
    assert drive.reset_encoder() == 15420 + 3259
    assert drive.encoder_ticks == 0


def test_late_and_early_timers_count_whole_periods() -> None:
    steps = motion.Steps(start_ns=0, period_ns=100)
    assert [steps.due(now) for now in (99, 150, 199, 520, 520, 600)] == [1, 0, 1, 3, 0, 1]


def test_a_period_that_was_counted_is_not_counted_again() -> None:
    steps = motion.Steps(start_ns=0, period_ns=100)
    # a thread that read the clock earlier asks later
    assert [steps.due(now) for now in (500, 300, 500, 600)] == [5, 0, 0, 1]


@pytest.mark.parametrize("period", [0.02, 0.5, 5.0])
def test_behind_a_suspension_one_step_is_driven_and_never_the_gap(period: float) -> None:
    steps = motion.Steps(start_ns=0, period_ns=int(period * 1e9))
    late = int(max(motion.LATE, period) * 1e9)
    assert steps.due(late) == round(late / (period * 1e9))  # a busy machine
    assert steps.due(late + int(20e9)) == 1
    assert steps.due(late + int((20 + period) * 1e9)) == 1
