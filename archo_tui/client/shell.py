"""`archo-tui VERB ...`: sends a verb to the console that runs here, and exits with its result."""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import sys

from archo_tui.client import find
from archo_tui.client.connection import Unreached
from archo_tui.client.protocol import (
    EXITS,
    FAILED,
    GONE,
    INTERRUPTED,
    NOT_REACHED,
    UNREACHED,
    WATCHING,
    YES_WORDS,
    is_stop,
    is_valid_timeout,
)
from archo_tui.errors import ArchoError
from archo_tui.robot_file.reserved import VERB_FLAGS, VERB_VALUES, VERBS
from archo_tui.safe_text import safe_lines
from archo_tui.surrogates import has_lone_surrogate

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence
    from contextlib import AbstractContextManager
    from types import FrameType
    from typing import Any

    from archo_tui.client.connection import Connection

# The verbs that have an option.
_VERBS_WITH_OPTION = {"--line": ("status",), "--follow": ("events", "echo"), "--once": ("echo",)}
_CALL_OFF_TIMEOUT = 3.0  # Seconds for the end of a goal that is called off.
_ANSWER_TIMEOUT = 2.0  # Further seconds in which a console that runs reports that.


class _CommandLine:
    """The words of a verb, with the options of this program taken out."""

    def __init__(self, words: Sequence[str]) -> None:
        """Sort the words; raise ValueError for a wrong option or no UTF-8, never for a STOP."""
        self.is_stop = is_stop({"words": list(words)})  # Whatever follows it.
        self.flags: set[str] = set()  # Options without a value.
        self.values: dict[str, str] = {}  # Options with a value, by name.
        self.rest: list[str] = []  # The verb and its arguments, for the console.
        remaining = iter(words)
        for word in remaining:
            if has_lone_surrogate(word):
                if self.is_stop:
                    continue
                raise ValueError(f"not UTF-8: {word!r}")
            name, equals, value = word.partition("=")
            if word in VERB_FLAGS:
                self.flags.add(word)
            elif name in VERB_VALUES:
                self.values[name] = value if equals else next(remaining, "")
                if not (self.values[name] or self.is_stop):
                    raise ValueError(f"{name} needs a value")
            else:
                self.rest.append(word)
        if not self.is_stop:
            self._check()

    def _check(self) -> None:
        verb = self.rest[0] if self.rest else ""
        for flag, verbs in _VERBS_WITH_OPTION.items():
            if flag in self.flags and verb not in verbs:
                has = "has" if len(verbs) == 1 else "have"
                raise ValueError(f"{verb} has no {flag}: {' and '.join(verbs)} {has} it")

    @property
    def is_endless(self) -> bool:
        """True for `--follow`, and `echo` without `--once`: the verb replies until interrupted."""
        if self.is_stop or "--help" in self.rest:
            return False
        echoes = self.rest[:1] == ["echo"] and "--once" not in self.flags
        return echoes or "--follow" in self.flags

    @property
    def timeout(self) -> float | None:
        """The seconds of `--timeout`; None without it and for a STOP. Raises ValueError."""
        text = None if self.is_stop else self.values.get("--timeout")
        try:
            seconds = None if text is None else float(text)
        except ValueError:
            seconds = -1.0
        if seconds is not None and not is_valid_timeout(seconds):
            raise ValueError(f"--timeout: not a time in s: {text}")
        return seconds


class _Interrupted(Exception):
    """The exception that SIGINT (ctrl+c) and SIGTERM raise while a verb is carried out."""


def run(
    words: Sequence[str],
    others: Iterable[str],
    attach: Callable[[], AbstractContextManager[Connection]] | None = None,
    meant: Mapping[str, Any] | None = None,
    helps: Callable[[], Mapping[str, str]] = dict,
) -> int:
    """Send a verb to the selected console, print its result, and return the exit code.

    A STOP goes to every console that could be meant. `attach` connects to the robot itself if no
    console runs, it only watches, or none confirms a STOP, unless a console was named. Errors are
    printed. `helps` returns the help of each verb that there is without a console.
    """
    if [*words] == ["stop", "--help"]:  # Whatever else follows it, it stops.
        _print(helps().get("stop", ""))
        return 0
    wants_help = "--help" in words[1:]
    try:
        command_line = _CommandLine(words)
        timeout = command_line.timeout
        to = command_line.values.get("--to") or (meant or {}).get("to")
        selection = {**(meant or {}), **({"to": to} if to else {})}
        if command_line.is_stop:
            return _stop(selection, command_line, attach)
        # If a console is named, no other one and no other robot is meant.
        if wants_help or "--to" in command_line.values or os.environ.get(find.CHOSEN):
            attach = None
        try:
            console = find.choose(selection)
        except find.NoConsole:
            if attach is None:
                raise
            with attach() as robot:
                return _send(robot, command_line, timeout, others)
        with contextlib.closing(console):
            return _send(console, command_line, timeout, others, attach)
    except (ValueError, ArchoError) as error:
        return _fail("misuse", str(error), words)
    except Unreached as error:
        if command_line.is_stop:
            return _fail(NOT_REACHED, str(error), words)
        return _print_without_console(words, others, str(error), helps)


def _fail(code: str, text: str, words: Sequence[str]) -> int:
    """Print why a command failed, with `--json` on standard output; return the exit code."""
    if "--json" in words:
        _print_json({"code": code, "text": text})
    else:
        complain(text)
    return EXITS[code]


def _print_without_console(
    words: Sequence[str], others: Iterable[str], why: str, helps: Callable[[], Mapping[str, str]]
) -> int:
    """Print help or an error that needs no console, and return the exit code.

    UNREACHED for an unknown verb, since the console may know it; MISUSED if it resembles another
    command.
    """
    word, wants_help = words[0], "--help" in words[1:]
    if wants_help or word not in VERBS:
        known = helps()
        if wants_help and word in known:
            _print(known[word])
            return 0
        near = "" if word in known else _nearest(word, (*known, *others))
        if near:
            return _fail("misuse", f"no command {word!r} (nearest: {near}), and {why}", words)
    return _fail(NOT_REACHED, why, words)


def _nearest(word: str, others: Iterable[str]) -> str:
    from archo_tui.nearest import nearest

    return nearest(word.lower(), others)


def _with_nearest(text: str, word: str, others: Iterable[str]) -> str:
    """Add the nearest of all commands to a console's error, which knows verbs only."""
    reason, found, verb = text.removesuffix(")").partition(" (nearest: ")
    reason = reason.removesuffix(" (help lists them")
    if reason != f"no command {word!r}":
        return text
    near = _nearest(word, (*others, verb) if found else others)
    return f"{reason} (nearest: {near})" if near else f"{reason} (archo-tui --help lists them)"


def print_consoles(*, as_json: bool) -> int:
    """Print the consoles that run here; return UNREACHED if there is none or one has a fault."""
    faults: list[str] = []
    try:
        found = find.find({}, faults)
    except Unreached as error:
        complain(str(error))
        return UNREACHED
    is_bad = not found
    for console in found:
        fault = console.fault(find.HELLO_TIMEOUT)
        is_bad = is_bad or bool(fault)
        if as_json:
            _print(json.dumps({**console.card, "answers": not fault}))
        else:
            _print(f"{console.description}{': ' if fault else ''}{fault}")
        console.close()
    if not found:
        complain(find.no_console_error({}, faults))
    return UNREACHED if is_bad else 0


def _stop(
    selection: Mapping[str, Any],
    command_line: _CommandLine,
    attach: Callable[[], AbstractContextManager[Connection]] | None,
) -> int:
    """Send STOP to every console that could be meant or to the robot, and return the worst code."""
    typed = [word for word in command_line.rest if is_stop({"words": word})]
    ignored = [word for word in command_line.rest if word not in typed[:1]]
    if ignored:
        complain(f"{(typed or ['stop'])[0]}: ignored: {' '.join(ignored)}")
    codes, unreached = [], ""
    try:
        ended = find.stop(selection, complain)
    except Unreached as error:
        ended, unreached = [], str(error)
    # A robot that is attached to acts where a console only watches.
    if attach is not None and "--to" not in command_line.values:
        ended = [stopped for stopped in ended if stopped.code != WATCHING]
    for stopped in ended:
        is_only = len(ended) == 1 and stopped.code == "done"
        text = stopped.text if is_only else f"{stopped.console}: {stopped.text}"
        codes.append(_print_result({"code": stopped.code, "text": text}, command_line))
    is_confirmed = any(stopped.code == "done" for stopped in ended)
    if attach is not None and not is_confirmed and "--to" not in command_line.values:
        try:
            with attach() as robot:
                codes.append(_send(robot, command_line, None, ()))
        except (Unreached, ArchoError) as error:
            if not ended:
                raise
            complain(str(error))
    elif unreached:
        raise Unreached(f"STOP was not sent: {unreached}")
    return max(codes)


def _send(
    console: Connection,
    command_line: _CommandLine,
    timeout: float | None,
    others: Iterable[str],
    attach: Callable[[], AbstractContextManager[Connection]] | None = None,
) -> int:
    """Send a verb, print the replies and the result, and return the exit code.

    A verb that acts goes to the robot itself where the console only watches. From now on the first
    SIGINT or SIGTERM calls the request off, a second one ends the program.
    """
    words = ["stop"] if command_line.is_stop else command_line.rest
    request: dict[str, Any] = {"words": words, "person": _has_person(), "timeout": timeout}
    if command_line.is_endless:
        as_text = "--json" not in command_line.flags
        request = {
            "words": command_line.rest,
            "follow": True,
            "as_text": as_text,
            "timeout": timeout,
        }
    if "--wait" in command_line.flags:
        request["wait"] = True
    try:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, _interrupt)
    except ValueError:  # This is not the main thread, which alone gets signals.
        pass
    try:
        seconds = None if timeout is None else timeout + _CALL_OFF_TIMEOUT + _ANSWER_TIMEOUT
        result = _request_result(console, request, command_line, seconds)
        if result["code"] == WATCHING and attach is not None:
            with attach() as robot:
                return _send(robot, command_line, timeout, others)
        return _print_result(result, command_line, others)
    except _Interrupted:
        for number in (signal.SIGINT, signal.SIGTERM):  # The next one ends the program.
            signal.signal(number, signal.SIG_DFL)
        return _give_up(console, command_line)


def _request_result(
    console: Connection,
    request: dict[str, Any],
    command_line: _CommandLine,
    seconds: float | None,
) -> dict[str, Any]:
    for reply in console.request(seconds, **request):
        if "code" in reply:
            return reply
        if "ask" in reply:
            answer = _ask_person(console, f"{reply['ask']} [y/N] ")
            if answer is not None:
                console.send({"answer": answer})
        elif "--json" in command_line.flags:
            _print_json(reply)
        elif "event" in reply:
            event = reply["event"]
            _print(f"{event['level']} {event['source']}: {event['text']}")
        elif "text" in reply:
            _print_topic_message(reply)
        elif "said" in reply:
            complain(reply["said"], prefix="")
    raise Unreached(GONE)


def _print_topic_message(reply: dict[str, Any]) -> None:
    """Print a message of a topic, with YAML's separator `---` behind one of several lines."""
    text = reply["text"]
    _print(f"{text}\n---" if "\n" in text else text)
    if reply["left_out"]:
        complain(f"{reply['left_out']} left out", prefix="")


def _print_result(
    result: dict[str, Any], command_line: _CommandLine, others: Iterable[str] = ()
) -> int:
    """Print a result, and return its exit code; only answers go to standard output."""
    code = EXITS.get(result["code"], FAILED)
    data = result.get("data")
    if "--json" in command_line.flags:
        _print_json(result)
    elif code:
        complain(_failure_text(result, command_line.rest, others))
    elif "--line" in command_line.flags and isinstance(data, dict) and "line" in data:
        _print(data["line"])
    elif result.get("tells"):
        _print(result["text"])
    elif result["text"]:
        complain(result["text"], prefix="")
    return code


def _failure_text(result: dict[str, Any], words: Sequence[str], others: Iterable[str]) -> str:
    """Return why a command failed, with the nearest command or option to a misspelled one."""
    if not words:
        return str(result["text"])
    verb, text = words[0], str(result["text"])
    if text.startswith(f"no command {verb!r}"):
        return _with_nearest(text, verb, others)
    option = next((word for word in words[1:] if word.startswith("--")), "")
    if result["code"] == "misuse" and option:
        known = (*VERB_FLAGS, *VERB_VALUES, "--yes")
        near = "" if option in known else _nearest(option, known)
        text += f" (nearest to {option}: {near})" if near else ""
    return f"{verb}: {text}"


def _give_up(console: Connection, command_line: _CommandLine) -> int:
    """Call the request off, wait 3 s at most, print its result, and return INTERRUPTED."""
    try:
        console.send({"give_up": True})
        for reply in console.replies(_CALL_OFF_TIMEOUT):
            if "code" in reply and "--json" in command_line.flags:
                _print_json(reply)
                break
            if "code" in reply:
                complain(reply["text"], prefix="")
                break
    except Unreached as error:
        complain(str(error))
    return INTERRUPTED


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    raise _Interrupted


def _has_person() -> bool:
    return all(stream is not None and stream.isatty() for stream in (sys.stdin, sys.stderr))


def _ask_person(console: Connection, question: str) -> bool | None:
    """Ask at the terminal; None if the console has said that nobody is to answer any more."""
    print(question, end="", file=sys.stderr, flush=True)
    if sys.stdin not in select.select([sys.stdin, console.socket], [], [])[0]:
        print(file=sys.stderr)
        return None
    return sys.stdin.readline().strip().lower() in YES_WORDS


def _print(text: str) -> None:
    print(safe_lines(text), flush=True)


def _print_json(message: dict[str, Any]) -> None:
    """Print a message as JSON without the request's id, which this program has made up."""
    _print(json.dumps({name: value for name, value in message.items() if name != "id"}))


def complain(text: str, prefix: str = "archo-tui: ") -> None:
    """Print lines on standard error, if that is open."""
    with contextlib.suppress(OSError):  # Nobody reads it; the result is the same.
        if sys.stderr is not None:
            print(f"{prefix}{safe_lines(text)}", file=sys.stderr)
