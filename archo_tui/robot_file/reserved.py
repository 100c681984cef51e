"""The console's own words, which no goal or command of a robot file may have as its id."""

from __future__ import annotations

from collections.abc import Collection

# The verbs that every robot with goals has, and the other words: subcommands of archo-tui, and the
# commands that only the screen has, as named in a keymap.
# made by python -m tests.generated: words
VERBS = (
    *("go", "cancel", "continue", "skip", "send_goal", "places", "save_place", "save_queue"),
    *("go_list", "stop", "release", "give_up_stop", "call", "status", "events", "history"),
    *("diagnostics", "forget", "keep", "alarms", "ack", "shelve", "get", "set", "undo"),
    *("params", "save", "load", "nodes", "start", "halt", "log_level", "lifecycle", "topics"),
    *("echo", "hz", "tf", "interface", "pub", "wait"),
)
_OTHERS = (
    *("all_parameters", "allow", "cancel_all", "chapter", "check", "completions", "consoles"),
    *("copy", "copy_command", "deny", "describe_robot", "details", "edit", "filter"),
    *("full_screen", "help", "help_everywhere", "journal", "keys", "launch", "level", "longer"),
    *("look", "mcp", "only_changed", "palette", "panel_1", "panel_2", "panel_3", "panel_4"),
    *("panel_5", "panel_6", "panel_7", "panel_8", "panel_9", "quiet_alarms", "quit"),
    *("quit_everywhere", "recordings", "replay", "resource", "restart", "restore", "rewind"),
    *("robot", "save_events", "search", "shorter", "start_stop", "suspend", "switch"),
    *("time_line", "whole_event"),
)
# end
# The options that a shell user may put before or after a verb: without and with a value.
VERB_FLAGS = ("--wait", "--json", "--line", "--follow", "--once")
VERB_VALUES = ("--to", "--timeout")
RESERVED = frozenset({*VERBS, *_OTHERS})


def unused_word(word: str, used: Collection[str]) -> str:
    """Return the word, or the first of `word_2`, `word_3` ... that is neither reserved nor used."""
    numbered, number = word, 1
    while numbered in RESERVED or numbered in used:
        number += 1
        numbered = f"{word}_{number}"
    return numbered
