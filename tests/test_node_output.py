"""What nodes print: whole lines, by their threads' names, and of a storm only some."""

from __future__ import annotations

import io
import threading

from archo_tui.node_output import NodeOutput


def printed(*texts: str, name: str = "/talker") -> tuple[list[tuple[str, str, str]], str]:
    """What is noted of these texts, written in a thread of that name, and what goes on."""
    notes: list[tuple[str, str, str]] = []
    other = io.StringIO()
    output = NodeOutput(other, lambda *note: notes.append(note))

    def write() -> None:
        for text in texts:
            output.write(text)

    thread = threading.Thread(target=write, name=name)
    thread.start()
    thread.join()
    return notes, other.getvalue()


def test_whole_lines_are_noted_with_their_node() -> None:
    notes, other = printed("one", " line", "\n", "two\nthr")
    assert notes == [("INFO", "talker stdout", "one line"), ("INFO", "talker stdout", "two")]
    assert other == ""


def test_what_no_node_prints_goes_on() -> None:
    assert printed("plain\n", name="stdin") == ([], "plain\n")


def test_of_a_storm_only_some_lines_are_noted_and_none_without_an_end() -> None:
    notes, _ = printed(*(f"line {number}\n" for number in range(1000)))
    assert 50 <= len(notes) < 1000
    notes, _ = printed("x" * 25_000)
    assert [len(text) for _, _, text in notes] == [10_000]


def test_one_that_is_freed_leaves_the_other_alone() -> None:
    other = io.StringIO()
    out = NodeOutput(other, lambda *_: None)
    other.close()
    out.close()  # as Python does when it frees it
