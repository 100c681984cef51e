"""What nodes print: whole lines, by their threads' names, and of a storm only some."""

from __future__ import annotations

import io
import threading

import pytest

from archo_tui.user_code.output import HarmlessOutput, NodeOutput

pytestmark = pytest.mark.pure


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


def test_what_a_nodes_thread_prints_is_noted_and_what_the_console_prints_goes_on() -> None:
    notes, other = printed("own\n", name="Thread-1 (work)")
    assert (notes, other) == ([("INFO", "Thread-1 (work) stdout", "own")], "")
    stream = io.StringIO()
    NodeOutput(stream, lambda *_: None).write("plain\n")
    assert stream.getvalue() == "plain\n"


def test_on_standard_error_nothing_is_for_the_terminal() -> None:
    stream = io.StringIO()
    assert HarmlessOutput(stream).write("\x1b[2Jone\ttwo\n\x07three") == 18
    assert stream.getvalue() == "\ufffd[2Jone two\n\ufffdthree"


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
