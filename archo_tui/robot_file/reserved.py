"""The console's own words, which no goal or command of a robot file may have as its id."""

from __future__ import annotations

from collections.abc import Collection

# The verbs that every robot has, as they are typed.
VERBS = (
    *("go", "cancel", "continue", "skip", "stop", "release", "give_up_stop"),
    *("status", "history", "events", "keep", "alarms", "ack", "shelve", "diagnostics", "forget"),
    *("params", "get", "set", "undo", "save", "load"),
    *("nodes", "topics", "echo", "hz", "interface", "tf"),
    *("start", "halt", "copy", "log_level", "lifecycle"),
    *("send_goal", "call", "pub"),
    *("places", "save_place", "save_queue", "go_list"),
)
# The options that a shell user may put before or after a verb: without and with a value.
VERB_FLAGS = ("--wait", "--leave", "--json", "--line", "--follow", "--once")
VERB_VALUES = ("--to", "--timeout")
RESERVED = frozenset(
    {
        *VERBS,
        *("help", "quit"),
        # Subcommands of archo-tui.
        *("check", "keys", "journal", "completions", "consoles", "wait", "mcp", "allow", "deny"),
        *("recordings", "replay", "rewind", "robot", "launch", "look", "chapter"),
        # Commands that only the screen has, as named in a keymap.
        *("cancel_all", "keep_robot", "describe_robot", "other_robot"),
        *(f"panel_{digit}" for digit in range(1, 10)),
        "time_line",
        *("edit", "restore", "switch", "only_changed", "all_parameters", "filter"),
        *("start_stop", "restart", "details", "resource"),
        *("level", "search", "copy_command", "full_screen", "whole_event", "save_events"),
        *("shorter", "longer"),
        *("help_everywhere", "palette", "quiet_alarms", "suspend", "quit_everywhere"),
    }
)


def unused_word(word: str, used: Collection[str]) -> str:
    """Return the word, or the first of `word_2`, `word_3` ... that is neither reserved nor used."""
    numbered, number = word, 1
    while numbered in RESERVED or numbered in used:
        number += 1
        numbered = f"{word}_{number}"
    return numbered
