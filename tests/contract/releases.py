"""Where rclpy's releases differ: the contracts are Kilted's, as the embedded engine is.

A test that is listed here fails on that release, and is red when it passes. Jazzy is 7.1.6, which
PyPI has; later patches of it keep some of these.
"""

from __future__ import annotations

from typing import NamedTuple


class Difference(NamedTuple):
    """A contract that a release does not keep."""

    test: str  # with all its parameters
    there: str  # what that release does instead
    hangs: bool = False  # the test would wait in vain


_DESTROYED = "a shutdown of the context leaves nodes and what they made undestroyed"

DIFFERENCES = {
    "jazzy": [
        Difference(
            "test_a_call_that_nobody_answers_in_time_raises", "`call` returns None when it is late"
        ),
        Difference("test_a_shutdown_destroys_nodes_and_all_that_they_made", _DESTROYED),
        Difference("test_after_shutdown_nothing_is_made_and_nothing_spins", _DESTROYED),
        Difference(
            "test_a_transition_that_does_not_start_here_is_an_error_and_changes_nothing",
            "it raises RCLError",
        ),
        Difference(
            "test_a_transition_that_does_not_start_here_is_answered_so",
            "the RCLError leaves the executor, and the client gets no answer",
            hangs=True,
        ),
        Difference("test_init_returns_what_ends_it_again", "init returns None"),
        Difference("test_spans_are_added_subtracted_and_multiplied", "spans have no arithmetic"),
        Difference("test_what_a_node_makes_ends_with_its_with", "publishers have no `with`"),
    ],
}
