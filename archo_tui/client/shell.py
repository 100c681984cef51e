"""`archo-tui VERB ...`: sends a verb to the console that runs here, and exits with its result."""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import sys

from archo_tui.base.errors import ArchoError
from archo_tui.base.safe_text import safe_lines
from archo_tui.base.surrogates import has_lone_surrogate
from archo_tui.client import find
from archo_tui.client.connection import HELLO_TIMEOUT, is_result
from archo_tui.client.errors import Unreached
from archo_tui.client.protocol import (
    EXITS,
    FAILED,
    INTERRUPTED,
    NOT_REACHED,
    UNREACHED,
    WATCHING,
    YES_WORDS,
    is_stop,
    timeout_of,
)
from archo_tui.robot_file.reserved import VERB_FLAGS, VERB_VALUES, VERBS

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence
    from contextlib import AbstractContextManager
    from types import FrameType
    from typing import Any

    from archo_tui.client.connection import Connection

# The verbs that have an option.
_VERBS_WITH_OPTION = {"--line": ("status",), "--follow": ("events", "echo"), "--once": ("echo",)}
_FOR_THE_CONSOLE = ("--yes", "--all", "--rate", "--times")  # Options among the words of a verb.
_LOOK = 0.2  # Seconds between two looks for a signal while a person is asked.
_CALL_OFF_TIMEOUT = 3.0  # Seconds for the end of a goal that is called off.
_SIGNALS = signal.SIGINT, signal.SIGTERM


class CommandLine:
    """The words of a verb, with the options of this program taken out."""

    def __init__(self, words: Sequence[str]) -> None:
        """Sort the words; raise ValueError for a wrong option or no UTF-8, never for a STOP."""
        self.is_stop = is_stop({"words": list(words)})  # Whatever follows it.
        self.flags: set[str] = set()  # Options without a value.
        self.values: dict[str, str] = {}  # Options with a value, by name.
        self.rest: list[str] = []  # The verb and its arguments, for the console.
        self.timeout: float | None = None
        remaining = iter(words)
        for word in remaining:
            name, equals, value = word.partition("=")
            if has_lone_surrogate(word):
                if not self.is_stop:
                    raise ValueError(f"not UTF-8: {word!r}")
            elif word in VERB_FLAGS:
                self.flags.add(word)
            elif name in VERB_VALUES:
                self.values[name] = value if equals else next(remaining, "")
            else:
                self.rest.append(word)
        if not self.is_stop:
            self._check_options()

    def _check_options(self) -> None:
        verb = self.rest[0] if self.rest else ""
        for name, value in self.values.items():
            if not value:
                raise ValueError(f"{name} needs a value")
        if text := self.values.get("--timeout"):
            try:
                self.timeout = timeout_of({"timeout": float(text)})
            except ValueError:
                raise ValueError(f"--timeout: not a time in s: {text}") from None
        for flag, verbs in _VERBS_WITH_OPTION.items():
            if flag in self.flags and verb not in verbs:
                has = "has" if len(verbs) == 1 else "have"
                raise ValueError(f"{verb} has no {flag}: {' and '.join(verbs)} {has} it")

    @property
    def request(self) -> dict[str, Any]:
        """The fields of the request; `echo` without `--once` follows its topic."""
        request: dict[str, Any] = {"words": ["stop"] if self.is_stop else self.rest}
        echoes = self.rest[:1] == ["echo"] and "--once" not in self.flags
        if (echoes or "--follow" in self.flags) and not (self.is_stop or "--help" in self.rest):
            return {**request, "follow": True, "as_text": "--json" not in self.flags}
        return {**request, "person": _has_person(), "wait": "--wait" in self.flags}


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
    try:
        line = CommandLine(words)
        to = line.values.get("--to") or (meant or {}).get("to")
        selection = {**(meant or {}), **({"to": to} if to else {})}
        # If a console is named, no other one and no other robot is meant.
        if "--to" in line.values:
            attach = None
        if line.is_stop:
            return _stop(selection, line, attach)
        if "--help" in words[1:] or os.environ.get(find.CHOSEN):
            attach = None
        try:
            console = find.choose(selection)
        except find.NoConsole:
            if attach is None:
                raise
            with attach() as robot:
                return _send(robot, line, others)
        with console:
            return _send(console, line, others, attach)
    except Unreached as error:
        if line.is_stop:
            return fail(NOT_REACHED, str(error), words)
        return _print_without_console(words, others, str(error), helps)
    except (ValueError, ArchoError) as error:
        return fail("misuse", str(error), words)


def fail(code: str, text: str, words: Sequence[str]) -> int:
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
            return fail("misuse", f"no command {word!r} (nearest: {near}), and {why}", words)
    return fail(NOT_REACHED, why, words)


def _nearest(word: str, others: Iterable[str]) -> str:
    from archo_tui.base.nearest import nearest

    return nearest(word.lower(), others)


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
        fault = console.fault(HELLO_TIMEOUT)
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
    line: CommandLine,
    attach: Callable[[], AbstractContextManager[Connection]] | None,
) -> int:
    """Send STOP to every console that could be meant or to the robot, and return the worst code."""
    typed = [word for word in line.rest if is_stop({"words": word})]
    ignored = [word for word in line.rest if word not in typed[:1]]
    if ignored:
        complain(f"{(typed or ['stop'])[0]}: ignored: {' '.join(ignored)}")
    try:
        ended = find.stop(selection, complain)
    except Unreached as error:
        if attach is None:
            raise Unreached(f"STOP was not sent: {error}") from None
        ended = []
    if attach is not None:  # A robot that is attached to acts where a console only watches.
        ended = [stopped for stopped in ended if stopped.code != WATCHING]
    codes = []
    for stopped in ended:
        is_only = len(ended) == 1 and stopped.code == "done"
        text = stopped.text if is_only else f"{stopped.console}: {stopped.text}"
        codes.append(_print_result({"code": stopped.code, "text": text}, line))
    if attach is not None and all(stopped.code != "done" for stopped in ended):
        try:
            with attach() as robot:
                codes.append(_send(robot, line))
        except ArchoError as error:
            if not ended:
                raise
            complain(str(error))
    return max(codes)


def _send(
    console: Connection,
    line: CommandLine,
    others: Iterable[str] = (),
    attach: Callable[[], AbstractContextManager[Connection]] | None = None,
) -> int:
    """Send a verb, print the replies and the result, and return the exit code.

    A verb that acts goes to the robot itself where the console only watches. From now on the first
    SIGINT or SIGTERM calls the request off, a second one ends the program.
    """
    with contextlib.suppress(ValueError):  # Not in the main thread, which alone gets signals.
        for number in _SIGNALS:
            signal.signal(number, _interrupt)
    try:
        for reply in console.request(line.timeout, **line.request):
            if "code" not in reply:
                _print_reply(console, reply, line)
        if reply["code"] == WATCHING and attach is not None:
            with attach() as robot:
                return _send(robot, line, others)
        return _print_result(reply, line, others)
    except _Interrupted:
        for number in _SIGNALS:  # The next one ends the program.
            signal.signal(number, signal.SIG_DFL)
        return _give_up(console, line)


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    raise _Interrupted


def _give_up(console: Connection, line: CommandLine) -> int:
    """Call the request off, wait 3 s at most, print its result, and return INTERRUPTED."""
    try:
        console.give_up()
        reply = next(filter(is_result, console.replies(_CALL_OFF_TIMEOUT)))
        if "--json" in line.flags:
            _print_json(reply)
        else:
            complain(reply["text"], prefix="")
    except Unreached as error:
        complain(str(error))
    return INTERRUPTED


def _print_reply(console: Connection, reply: dict[str, Any], line: CommandLine) -> None:
    """Print what comes before the result; a question is put to the person at the terminal."""
    if "ask" in reply:
        answer = _ask_person(console, f"{reply['ask']} [y/N] ")
        if answer is not None:
            console.send({"answer": answer})
    elif "--json" in line.flags:
        _print_json(reply)
    elif "event" in reply:
        event = reply["event"]
        _print(f"{event['level']} {event['source']}: {event['text']}")
    elif "text" in reply:  # A message, with YAML's separator behind one of several lines.
        _print(f"{reply['text']}\n---" if "\n" in reply["text"] else reply["text"])
        if reply["left_out"]:
            complain(f"{reply['left_out']} left out", prefix="")
    elif "said" in reply:
        complain(reply["said"], prefix="")


def _print_result(result: dict[str, Any], line: CommandLine, others: Iterable[str] = ()) -> int:
    """Print a result, and return its exit code; only answers go to standard output."""
    code = EXITS.get(result["code"], FAILED)
    data = result.get("data")
    if "--json" in line.flags:
        _print_json(result)
    elif code:
        complain(_failure_text(result, line.rest, others))
    elif "--line" in line.flags and isinstance(data, dict) and "line" in data:
        _print(data["line"])
    elif result.get("tells"):
        _print(result["text"])
    elif result["text"]:
        complain(result["text"], prefix="")
    return code


def _failure_text(result: dict[str, Any], words: Sequence[str], others: Iterable[str]) -> str:
    """Return why a command failed, with the nearest command or option to a misspelled one."""
    text = str(result["text"])
    if not words:
        return text
    unknown = f"no command {words[0]!r}"
    if text.startswith(unknown):  # The console knows verbs only.
        verb = text.removesuffix(")").rpartition("(nearest: ")
        near = _nearest(words[0], (*others, *([verb[2]] if verb[1] else [])))
        return (
            f"{unknown} (nearest: {near})" if near else f"{unknown} (archo-tui --help lists them)"
        )
    option = next((word for word in words[1:] if word.startswith("--")), "")
    known = (*VERB_FLAGS, *VERB_VALUES, *_FOR_THE_CONSOLE)
    near = _nearest(option, known) if option not in known else ""
    hint = f" (nearest to {option}: {near})" if near and result["code"] == "misuse" else ""
    return f"{words[0]}: {text}{hint}"


def _has_person() -> bool:
    return all(stream is not None and stream.isatty() for stream in (sys.stdin, sys.stderr))


def _ask_person(console: Connection, question: str) -> bool | None:
    """Ask at the terminal; None if the console has said that nobody is to answer any more."""
    print(question, end="", file=sys.stderr, flush=True)
    ready: list[Any] = []
    while not ready:  # A signal just before `select` is handled when that returns.
        ready = select.select([sys.stdin, console.socket], [], [], _LOOK)[0]
    if sys.stdin not in ready:
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
