"""Tracebacks for the person who wrote the node, and the whole lines that nodes print."""

from __future__ import annotations

import io
import json
import json.decoder
import threading
from pathlib import Path

import pytest

import archo_tui
from archo_tui.user_code.errors import OwnCode, traceback_without
from archo_tui.user_code.output import HarmlessOutput, NodeOutput

pytestmark = pytest.mark.pure


def report(text: str) -> str:
    """What is said of an error in the json package, which stands in for the engine."""
    try:
        json.loads(text)
    except ValueError as error:
        return traceback_without(error, json)
    raise AssertionError


def test_the_engines_frames_are_only_counted() -> None:
    said = report("{")
    assert "in report" in said
    assert "decoder.py" not in said
    assert said.splitlines()[0] == "Traceback (most recent call last):"
    assert said.splitlines()[-1] == "(3 frames of the engine are left out)"
    assert "JSONDecodeError: Expecting property name" in said


def test_an_error_that_never_left_the_engine_is_shown_whole() -> None:
    with pytest.raises(ValueError) as caught:
        json.loads("{")
    error = caught.value
    assert error.__traceback__ is not None
    error.__traceback__ = error.__traceback__.tb_next  # without the frame of this test
    assert "decoder.py" in traceback_without(error, json)


def test_python_itself_is_not_the_users_though_it_be_in_their_folder() -> None:
    home = Path(json.__file__).resolve().parents[4]
    code = OwnCode("mine.py", home / "mine.py")
    assert code.is_own(str(home / "helper.py"))
    assert not code.is_own(json.__file__)


def test_the_console_is_not_the_users_though_it_be_in_their_folder() -> None:
    clone = Path(archo_tui.__file__).resolve().parent.parent
    code = OwnCode("mine.py", clone / "mine.py")
    assert not code.is_own(f"{clone}/archo_tui/ros/embedded/cdr.py")
    assert code.is_own(f"{clone}/helpers.py")


def test_errors_that_a_deep_recursion_has_chained_are_all_told() -> None:
    error: Exception = ValueError("the first")
    for number in range(2000):
        later = RuntimeError(number)
        later.__context__ = error
        error = later
    said = traceback_without(error, json)
    assert said.startswith("ValueError: the first\n")
    assert said.rstrip().endswith("RuntimeError: 1999")


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
