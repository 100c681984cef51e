"""The command line of `archo-tui`, which imports rclpy and Textual only when it must."""

from __future__ import annotations

import errno
import gc
import os
import signal
import sys
from collections.abc import Sequence
from io import TextIOWrapper

from archo_tui.cli.dispatch import run_words
from archo_tui.cli.options import split_ros_args
from archo_tui.cli.output import FAILED, MISUSED, ClosedOutput, complain
from archo_tui.cli.restart import command_line
from archo_tui.collector import ShortPauses
from archo_tui.errors import ArchoError
from archo_tui.system import END_SIGNALS

_AGAIN = 100  # shutdown.RESTART, which is not imported for --help.


def main(argv: Sequence[str] | None = None) -> int:
    """Run the program, print a user's mistake in one line, and return the exit code.

    A console that asks for a restart replaces this process.
    """
    if signal.getsignal(signal.SIGINT) == signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # Until heed_signals there is nothing to undo.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # None if it is closed.
            stream.reconfigure(errors="backslashreplace")
    given = sys.argv[1:] if argv is None else argv
    words, ros_args = split_ros_args(given)
    try:
        with ShortPauses():
            code = run_words(words, ros_args)
        if code == _AGAIN:
            for number in END_SIGNALS:  # An ignored one would be ignored after `exec`, too.
                signal.signal(number, signal.SIG_DFL)
            os.execv(sys.executable, command_line(given))
        if sys.stdout is not None:
            sys.stdout.flush()
    except ArchoError as error:
        complain(str(error))
        return MISUSED
    except OSError as error:
        closed = isinstance(sys.stdout, ClosedOutput)
        written = error.errno in (errno.ENOSPC, errno.EPIPE, errno.EIO) or closed
        if not written or sys.stdout is None:
            raise
        if not closed:  # Python flushes once more at its end.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        # A reader that ends early, such as `head`, needs no message.
        if error.errno != errno.EPIPE:
            complain(f"cannot write to standard output: {error.strerror}")
        return FAILED
    finally:
        if isinstance(sys.stdout, ClosedOutput):
            sys.stdout = None
        gc.enable()
        if signal.getsignal(signal.SIGINT) == signal.SIG_DFL:
            signal.signal(signal.SIGINT, signal.default_int_handler)
    return code
