"""`archo-tui VERB ...`: sends a verb to the console that runs here, and exits with its result."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys

from archo_tui.errors import ArchoError
from archo_tui.remote import finder
from archo_tui.remote.client import Unreached
from archo_tui.remote.protocol import (
    EXITS,
    FAILED,
    GONE,
    INTERRUPTED,
    NOT_REACHED,
    UNREACHED,
    WATCHING,
    is_stop,
)
from archo_tui.robot_file.reserved import VERB_FLAGS, VERB_VALUES, VERBS
from archo_tui.safe_text import safe_lines
from archo_tui.surrogates import has_lone_surrogate

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
    from contextlib import AbstractContextManager
    from pathlib import Path
    from types import FrameType
    from typing import Any, Protocol

    class Speaks(Protocol):
        """A connection to a console, or what stands for one."""

        def request(self, within: float | None = None, **asked: Any) -> Iterator[dict[str, Any]]:
            """Send a request, and yield all replies to it, the result last."""

        def remaining_replies(self, within: float | None = None) -> Iterator[dict[str, Any]]:
            """Yield the replies that follow; `Unreached` is raised after `within` seconds."""

        def send(self, said: dict[str, Any]) -> None:
            """Send an answer, or `give_up`, to the request that is being carried out."""


# The verbs that have an option.
_VERBS_OF = {"--line": ("status",), "--follow": ("events", "echo"), "--once": ("echo",)}
_CALL_OFF_TIMEOUT = 3.0  # Seconds for the end of a goal that is called off.
_ANSWER_TIMEOUT = 2.0  # Further seconds in which a console that runs reports that.


class _CommandLine:
    """The words of a verb, with the options of this program taken out.

    Attributes:
        stops: True if the words are a STOP.
        flags: Options without a value, as typed.
        values: Options with a value.
        rest: The words for the console: the verb and its arguments.
    """

    def __init__(self, words: Sequence[str]) -> None:
        """Sort the words.

        Raises:
            ValueError: An option is wrong, or a word no UTF-8. Never for a STOP, which is one
                whatever follows it.
        """
        self.stops = is_stop({"words": list(words)})
        self.flags: set[str] = set()
        self.values: dict[str, str] = {}
        self.rest: list[str] = []
        given = iter(words)
        for word in given:
            if has_lone_surrogate(word):
                if self.stops:
                    continue
                raise ValueError(f"not UTF-8: {word!r}")
            name, equals, value = word.partition("=")
            if word in VERB_FLAGS:
                self.flags.add(word)
            elif name in VERB_VALUES:
                self.values[name] = value if equals else next(given, "")
                if not (self.values[name] or self.stops):
                    raise ValueError(f"{name} needs a value")
            else:
                self.rest.append(word)
        if not self.stops:
            self._check()

    def _check(self) -> None:
        """Check the options of this program; the console checks the rest.

        Raises:
            ValueError: An option belongs to another verb.
        """
        verb = self.rest[0] if self.rest else ""
        for flag, its in _VERBS_OF.items():
            if flag in self.flags and verb not in its:
                has = "has" if len(its) == 1 else "have"
                raise ValueError(f"{verb} has no {flag}: {' and '.join(its)} {has} it")
        if "--leave" in self.flags and "--wait" not in self.flags:
            raise ValueError("--leave goes with --wait")

    @property
    def follows(self) -> bool:
        """True if replies are wanted until this program ends, as of `echo` without `--once`."""
        if self.stops or "--help" in self.rest:
            return False
        echoes = self.rest[:1] == ["echo"] and "--once" not in self.flags
        return echoes or "--follow" in self.flags

    @property
    def timeout(self) -> float | None:
        """The seconds of `--timeout`; None without one, and for a STOP.

        Raises:
            ValueError: It is no time.
        """
        text = None if self.stops else self.values.get("--timeout")
        try:
            seconds = None if text is None else float(text)
        except ValueError:
            seconds = -1.0
        if seconds is not None and not 0 <= seconds < 1e9:
            raise ValueError(f"--timeout: not a time in s: {text}")
        return seconds


class _Interrupted(Exception):
    """SIGINT, as by ctrl+c, or SIGTERM came."""


def run(
    words: Sequence[str],
    others: Iterable[str],
    attach: Callable[[], AbstractContextManager[Speaks]] | None = None,
    meant: Mapping[str, Any] | None = None,
    robot_file: Path | None = None,
) -> int:
    """Send a verb to the console that is meant, and return the exit code.

    Args:
        words: The verb and its arguments.
        others: Commands that are no verbs, to name the nearest one to a misspelled word.
        attach: Connects to the robot itself where no console runs; None: nothing can.
        meant: `to`, `engine` and `domain` that were typed before the verb.
        robot_file: The robot file whose verbs are known where no console runs; None: ARCHO's.
    """
    # A STOP has help only if exactly that is typed: whatever else follows it, it stops.
    if list(words[1:]) == ["--help"] or (words[0] == "wait" and "--help" in words):
        from archo_tui.remote.verb_help import own

        known = own(words[0])
        if known:
            if "--json" in words:
                _print_json({"code": "done", "text": known})
            else:
                _print(known)
            return 0
    helps = "--help" in words[1:]
    try:
        given = _CommandLine(words)
        timeout = given.timeout
        to = given.values.get("--to") or (meant or {}).get("to")
        selection = {**(meant or {}), **({"to": to} if to else {})}
        if given.stops:
            return _stop(selection, given, attach)
        # If a console is named, no other one and no other robot is meant.
        if helps or "--to" in given.values or os.environ.get(finder.CHOSEN):
            attach = None
        try:
            console = finder.choose(selection)
        except finder.Nobody:
            if attach is None:
                raise
            with attach() as robot:
                return _send(robot, given, timeout, others)
        with contextlib.closing(console):
            return _send(console, given, timeout, others, attach)
    except (ValueError, ArchoError) as error:
        return _fail("misuse", str(error), words)
    except Unreached as error:
        if given.stops:
            return _fail(NOT_REACHED, str(error), words)
        return _unreached(words, others, str(error), robot_file)


def _fail(code: str, text: str, words: Sequence[str]) -> int:
    """Print why a command failed, as an object with `--json`, and return the exit code."""
    if "--json" in words:
        _print_json({"code": code, "text": text})
    else:
        _complain(text)
    return EXITS[code]


def _unreached(
    words: Sequence[str], others: Iterable[str], why: str, robot_file: Path | None = None
) -> int:
    """Print what is known without a console, and return the exit code.

    A robot file may have verbs that are not known here: only a misspelled one is misuse.
    """
    word, helps = words[0], "--help" in words[1:]
    if helps or word not in (*VERBS, "wait"):
        from archo_tui.remote.verb_help import help_of, verbs_of_file

        known = verbs_of_file(robot_file)
        if helps and word in known:
            _print(help_of(word, robot_file))
            return 0
        near = "" if word in known else _nearest(word, (*known, "wait", *others))
        if near:
            return _fail("misuse", f"no command {word!r} (nearest: {near}), and {why}", words)
    return _fail(NOT_REACHED, why, words)


def _nearest(word: str, others: Iterable[str]) -> str:
    """Return the word that is spelled most alike; empty if none is."""
    from archo_tui.nearest import nearest

    return nearest(word.lower(), others)


def _with_nearest(text: str, word: str, others: Iterable[str]) -> str:
    """Add the nearest command to a console's error about an unknown verb.

    The console knows verbs only, this program other commands, too.
    """
    said, found, verb = text.removesuffix(")").partition(" (nearest: ")
    said = said.removesuffix(" (help lists them")
    if said != f"no command {word!r}":
        return text
    near = _nearest(word, (*others, verb) if found else others)
    return f"{said} (nearest: {near})" if near else f"{said} (archo-tui --help lists them)"


def consoles(words: Sequence[str]) -> int:
    """Print the consoles that run here.

    Args:
        words: With `--json` among them, each console is printed as JSON.

    Returns:
        The exit code: UNREACHED if none runs or one has a fault, such as no answer or another
        version of the protocol; otherwise 0.
    """
    faults: list[str] = []
    try:
        found = finder.find({}, faults)
    except Unreached as error:
        _complain(str(error))
        return UNREACHED
    for console in found:
        if "--json" in words:
            _print(json.dumps({**console.who, "answers": not console.fault}))
        elif console.hello:
            _print(f"{console.described}{': ' if console.fault else ''}{console.fault}")
        else:
            _print(f"{console.described}: does not answer")
        console.close()
    if not found:
        _complain(finder.no_console_error({}, faults))
    return UNREACHED if not found or any(console.fault for console in found) else 0


def _stop(
    selection: Mapping[str, Any],
    given: _CommandLine,
    attach: Callable[[], AbstractContextManager[Speaks]] | None,
) -> int:
    """Send STOP to every console that could be meant, or else to the robot itself.

    Args:
        selection: Which consoles are meant, as for `finder.find`.
        given: The words of the STOP; those after the first are ignored, with a warning.
        attach: Connects to the robot itself, which is done if no console confirms the STOP and
            no `--to` is given; None: nothing can.

    Returns:
        The highest exit code of all results.

    Raises:
        Unreached: Neither a console nor the robot could be reached.
        ArchoError: No console is there, and the session for the robot itself cannot begin.
    """
    if len(given.rest) > 1:
        _complain(f"{given.rest[0]}: ignored: {' '.join(given.rest[1:])}")
    codes, unreached = [], ""
    try:
        ended = finder.stop(selection, _complain)
    except Unreached as error:
        ended, unreached = [], str(error)
    if attach is not None and "--to" not in given.values:  # It acts where a console only watches.
        ended = [one for one in ended if one.code != WATCHING]
    for one in ended:
        text = one.text if len(ended) == 1 and one.code == "done" else f"{one.console}: {one.text}"
        codes.append(_print_result({"code": one.code, "text": text}, given))
    is_confirmed = any(one.code == "done" for one in ended)
    if attach is not None and not is_confirmed and "--to" not in given.values:
        try:
            with attach() as robot:
                codes.append(_send(robot, given, None, ()))
        except (Unreached, ArchoError) as error:
            if not ended:
                raise
            _complain(str(error))
    elif unreached:
        raise Unreached(unreached)
    return max(codes)


def _send(
    console: Speaks,
    given: _CommandLine,
    timeout: float | None,
    others: Iterable[str],
    attach: Callable[[], AbstractContextManager[Speaks]] | None = None,
) -> int:
    """Send a verb to a console; if that one only watches and must act, to the robot itself.

    Args:
        console: The console that is meant.
        given: The words of the verb.
        timeout: Seconds that the user gave; None: none.
        others: As for `run`.
        attach: Connects to the robot itself; None: nothing can.

    Returns:
        The exit code.
    """
    words = given.rest[:1] if given.stops else given.rest
    asked: dict[str, Any] = {"words": words, "person": _has_person(), "timeout": timeout}
    if given.follows:
        as_text = "--json" not in given.flags
        asked = {"words": given.rest, "follow": True, "as_text": as_text, "timeout": timeout}
    if "--wait" in given.flags:
        asked |= {"wait": True, "leave": "--leave" in given.flags}
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, _interrupt)
    except ValueError:  # This is not the main thread, which alone gets signals.
        pass
    try:
        within = None if timeout is None else timeout + _CALL_OFF_TIMEOUT + _ANSWER_TIMEOUT
        result = _result(console, asked, given, within)
        if result["code"] == WATCHING and attach is not None:
            with attach() as robot:
                return _send(robot, given, timeout, others)
        return _print_result(result, given, others)
    except _Interrupted:
        for number in (signal.SIGINT, signal.SIGTERM):  # The next one ends the program.
            signal.signal(number, signal.SIG_DFL)
        return INTERRUPTED if asked.get("leave") else _give_up(console, given)


def _result(
    console: Speaks, asked: dict[str, Any], given: _CommandLine, within: float | None
) -> dict[str, Any]:
    """Send a request, print or answer the replies, and return the result.

    Raises:
        Unreached: The console has gone, or did not answer within so many seconds.
    """
    for said in console.request(within, **asked):
        if "code" in said:
            return said
        if "ask" in said:
            console.send({"answer": _answer(f"{said['ask']} [y/N] ")})
        elif "--json" in given.flags:
            _print_json(said)
        elif "event" in said:
            event = said["event"]
            _print(f"{event['level']} {event['source']}: {event['text']}")
        elif "text" in said:
            _print_followed(said)
        elif "said" in said:
            _complain(said["said"], prefix="")
    raise Unreached(GONE)


def _print_followed(said: dict[str, Any]) -> None:
    """Print a message of a topic, with YAML's separator behind one of several lines."""
    text = said["text"]
    _print(f"{text}\n---" if "\n" in text else text)
    if said["left_out"]:
        _complain(f"{said['left_out']} left out", prefix="")


def _print_result(result: dict[str, Any], given: _CommandLine, others: Iterable[str] = ()) -> int:
    """Print a result, or why the command failed, and return its exit code.

    Args:
        result: The console's result.
        given: The words and the options that were typed.
        others: The commands of this program besides verbs, for the nearest one to a misspelled.
    """
    code = EXITS.get(result["code"], FAILED)
    data = result.get("data")
    if "--json" in given.flags:
        _print_json(result)
    elif code:
        _complain(_why_not(result, given.rest, others))
    elif "--help" in given.rest[1:] and not given.stops:
        from archo_tui.remote.verb_help import with_options

        _print(with_options(given.rest[0], result["text"], tuple(data or ())))
    elif "--line" in given.flags and isinstance(data, dict) and "line" in data:
        _print(data["line"])
    elif result.get("tells"):
        _print(result["text"])
    elif result["text"]:
        _complain(result["text"], prefix="")
    return code


def _why_not(result: dict[str, Any], words: Sequence[str], others: Iterable[str]) -> str:
    """Return why a command failed, with its verb in front unless the text names the verb.

    A console knows nothing of a client's options, so the option nearest to a misspelled one is
    named here.
    """
    if not words:
        return str(result["text"])
    verb, said = words[0], str(result["text"])
    if said.startswith(f"no command {verb!r}"):
        return _with_nearest(said, verb, others)
    option = next((word for word in words[1:] if word.startswith("--")), "")
    if result["code"] == "misuse" and option:
        from archo_tui.remote.verb_help import every_option

        near = _nearest(option, every_option())
        said += f" (nearest to {option}: {near})" if near else ""
    return f"{verb}: {said}"


def _give_up(console: Speaks, given: _CommandLine) -> int:
    """Call off the request, wait until that is confirmed, and return the exit code."""
    try:
        console.send({"give_up": True})
        for said in console.remaining_replies(_CALL_OFF_TIMEOUT):
            if "code" in said and "--json" in given.flags:
                _print_json(said)
                break
            if "code" in said:
                _complain(said["text"], prefix="")
                break
    except Unreached as error:
        _complain(str(error))
    return INTERRUPTED


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    raise _Interrupted


def _has_person() -> bool:
    return all(one is not None and one.isatty() for one in (sys.stdin, sys.stderr))


def _answer(question: str) -> bool:
    print(question, end="", file=sys.stderr, flush=True)
    return sys.stdin.readline().strip().lower() in ("y", "yes")


def _print(text: str) -> None:
    print(safe_lines(text), flush=True)


def _print_json(said: dict[str, Any]) -> None:
    """Print a message without the request's id, which this program has made up."""
    _print(json.dumps({name: value for name, value in said.items() if name != "id"}))


def _complain(text: str, prefix: str = "archo-tui: ") -> None:
    with contextlib.suppress(OSError):  # Nobody reads it; the result is the same.
        if sys.stderr is not None:
            print(f"{prefix}{safe_lines(text)}", file=sys.stderr)
