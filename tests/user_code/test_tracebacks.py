"""The traceback of a node that crashed, for the person who wrote it."""

from __future__ import annotations

import json
import json.decoder
from pathlib import Path

import pytest

import archo_tui
from archo_tui.user_code.errors import OwnCode, traceback_without

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


def chained() -> None:
    try:
        json.loads("{")
    except ValueError as error:
        raise KeyError("x") from error


def test_what_led_to_an_error_is_cut_in_the_same_way() -> None:
    with pytest.raises(KeyError) as caught:
        chained()
    said = traceback_without(caught.value, json)
    assert said.count("Traceback (most recent call last):") == 2
    assert "in chained" in said
    assert "decoder.py" not in said


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
