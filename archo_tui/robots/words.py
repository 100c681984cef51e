"""The console's own words: no goal or command of a robot file may be called by one of them.

Else one typed word, or one line of a keymap, would mean two things.
"""

from __future__ import annotations

from collections.abc import Collection

# what `--plain` takes
VERBS = (
    *("go", "cancel", "continue", "skip", "stop", "release"),
    *("set", "undo", "params", "status", "help", "quit"),
)
# the ids of the screen's commands, as in a keymap
COMMANDS = (
    *("go", "cancel", "cancel_all", "continue_queue", "drop_target", "stop", "give_up_stop"),
    *("release", "any_goal", "any_service", "keep_robot", "acknowledge", "alarms"),
    *(f"panel_{number}" for number in range(1, 8)),
    *("edit", "restore", "switch", "only_changed", "filter", "undo", "save", "load"),
    *("start_stop", "copy_node", "details"),
    *("level", "search", "copy_command", "full_screen", "whole_event", "save_events"),
    *("history", "shorter", "longer"),
    *("help", "help_everywhere", "palette", "quiet_alarms", "suspend", "quit", "quit_everywhere"),
)
TAKEN = frozenset((*VERBS, *COMMANDS))


def free(word: str, used: Collection[str]) -> str:
    """The word, or the first of `word_2`, `word_3` ... that is neither taken nor used."""
    numbered, number = word, 1
    while numbered in TAKEN or numbered in used:
        number += 1
        numbered = f"{word}_{number}"
    return numbered
