"""Starting and stopping, many times in a row, leaves nothing behind."""

from __future__ import annotations

import gc
import os
import threading

import pytest

from archo_tui.session.options import Options
from archo_tui.session.session import Session
from tests.support import chosen, clock
from tests.support.night import corners

ROUNDS = 50


def test_what_is_said_behind_the_end_is_heard_by_nobody_and_disturbs_nobody() -> None:
    session = Session(Options(engine=chosen.ENGINE, domain_id=chosen.next_domain()), clock.current)
    session.start()
    assert session.close() == []
    session.robot.note("ERROR", "motor_controller", "crashed")


def descriptors() -> int:
    gc.collect()
    return len(os.listdir("/proc/self/fd"))


@pytest.mark.parametrize("rounds", corners([8], [ROUNDS]))
def test_sessions_in_a_row_leave_no_thread_and_no_descriptor(rounds: int) -> None:
    options = Options(engine=chosen.ENGINE, domain_id=chosen.next_domain())
    with Session(options, clock.current):
        pass  # what is made once, is made now
    before, threads = descriptors(), threading.active_count()
    for _ in range(rounds):
        session = Session(options, clock.current)
        session.start()
        assert session.close() == []
        del session
        if chosen.ENGINE == "ros2":
            gc.collect()  # rclpy frees a context's descriptors with its last reference
    assert threading.active_count() == threads
    assert descriptors() <= before + 4
