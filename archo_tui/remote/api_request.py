"""A request of a Python program, on a connection of its own."""

from __future__ import annotations

import contextlib
import socket
import time
from collections.abc import Iterator, Mapping
from typing import Any

from archo_tui.remote import client, finder
from archo_tui.remote.api_errors import Unreached, convert_unreached
from archo_tui.remote.protocol import LONGEST_WAIT

# Seconds without a message after which the console is asked whether it still answers.
_SILENCE = 10.0
# Seconds behind `timeout` for the result: a console calls off for 3 s, and reports it then.
_CALL_OFF_TIMEOUT = 5.0


class Request:
    """A connection for one request; an exception inside its context calls the request off."""

    def __init__(self, path: str, timeout: float | None, fields: Mapping[str, Any]) -> None:
        self._path, self._timeout, self._fields = path, timeout, fields
        self._end: float | None = None  # Monotonic time in seconds.
        with convert_unreached():
            self._console = finder.reach(path)

    def __enter__(self) -> Request:
        return self

    def __exit__(self, kind: object, error: BaseException | None, at: object) -> None:
        if error is not None:
            self.give_up()
        self.close()

    def __del__(self) -> None:
        if hasattr(self, "_console"):  # An iterator over events was never begun.
            self.close()

    def send(self) -> None:
        """Send the request; its timeout begins now."""
        if self._timeout is not None:
            self._end = time.monotonic() + self._timeout + _CALL_OFF_TIMEOUT
        with convert_unreached():
            self._send_message({"id": 1, "timeout": self._timeout, **self._fields})

    def replies(self) -> Iterator[dict[str, Any]]:
        """Yield all replies of the console, the result last.

        After each 10 s without a reply, another connection tests whether the console still answers.
        """
        reply: dict[str, Any] = {}
        while "code" not in reply:
            left = LONGEST_WAIT if self._end is None else self._end - time.monotonic()
            try:
                reply = next(self._console.remaining_replies(min(max(left, 0.0), _SILENCE)))
            except client.Silent as error:
                if left <= _SILENCE:
                    raise Unreached("unreached", str(error)) from None
                self._check_that_it_answers()
                continue
            except client.Unreached as error:
                raise Unreached("unreached", str(error)) from None
            yield reply

    def result(self) -> dict[str, Any]:
        """Wait for the result and return it; other replies are dropped."""
        reply: dict[str, Any] = {}
        for reply in self.replies():  # noqa: B007  # the last one is wanted
            pass
        return reply

    def give_up(self) -> None:
        """Tell the console to call the request off; do not wait, and ignore a broken connection."""
        with contextlib.suppress(client.Unreached):
            self._send_message({"give_up": True})

    def close(self) -> None:
        """Close the connection: the console calls off what is still underway."""
        self._console.close()

    def shut_down(self) -> None:
        """End the connection from another thread: `replies`, which closes it, raises Unreached."""
        if self._console.socket is not None:
            with contextlib.suppress(OSError):  # It is closed already.
                self._console.socket.shutdown(socket.SHUT_RDWR)

    def _send_message(self, message: dict[str, Any]) -> None:
        assert self._console.socket is not None
        if self._console.socket.fileno() >= 0:  # Not closed.
            self._console.send(message)

    def _check_that_it_answers(self) -> None:
        with convert_unreached():
            finder.reach(self._path, _SILENCE).close()
