"""The connection of the assistant's process to the console.

The console knows the assistant by its connection: when it closes, every approval request of the
assistant is void and its goal is cancelled. So it stays open as long as the process lives. A STOP
has a connection of its own: it waits for no other request.
"""

from __future__ import annotations

import contextlib
import threading
from typing import Any

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.client import find
from archo_tui.client.connection import Connection, Silent
from archo_tui.client.errors import Unreached
from archo_tui.client.protocol import LOST

_ASSISTANT = {"assistant": True}
ANSWER_TIMEOUT = 15.0  # Seconds in which a live console answers anything, STOP included.
SILENT = "the console does not answer: is it suspended? The robot may still be moving"
CONSOLE_CHANGED = (
    "The console was restarted, or is another one now. What was asked for before is void: look at "
    "`status` before anything else."
)


class ConsoleConnection:
    """The assistant's connection to a console, which each request opens if needed."""

    def __init__(self, to: str) -> None:
        self._to = to  # "": that which ARCHO_TUI_CONSOLE names, or else the only one.
        self._lock = threading.Lock()  # Held by the request that is carried out.
        self._console: Connection | None = None
        self._name = ""  # The name of the last console's socket.
        self._notice = ""

    def take_notice(self) -> str:
        """Return and clear the notice of a restarted console, or of another one; "" for none."""
        notice, self._notice = self._notice, ""
        return notice

    async def request(
        self, answer_timeout: float = ANSWER_TIMEOUT, **fields: Any
    ) -> dict[str, Any]:
        """Send a request after those before it, and return its result, or raise Unreached."""
        news: list[str] = []
        try:
            return await in_daemon(self._request, answer_timeout, fields, news)
        finally:
            self._notice = "".join(news) or self._notice

    def _request(
        self, answer_timeout: float, fields: dict[str, Any], news: list[str]
    ) -> dict[str, Any]:
        with self._lock:
            if self._console is None or self._console.has_ended:
                console = find.choose({"to": self._to})
                if self._name:
                    news.append(CONSOLE_CHANGED)
                self._console, self._name = console, console.card["name"]
            try:
                return self._console.answer(answer_timeout, **_ASSISTANT, **fields)
            except Silent:  # It may be suspended, and answer the next one.
                raise Unreached(SILENT) from None
            except Unreached:  # It has gone, or got half a request.
                self._console.close()
                raise

    async def stop(self) -> list[dict[str, Any]]:
        """Send STOP at once, whatever else waits, and return the consoles' results.

        If the known console has gone or does not answer, STOP goes to every one that could be
        meant. A code other than `done` means not confirmed. Raises Unreached.
        """
        return await in_daemon(self._stop)

    def _stop(self) -> list[dict[str, Any]]:
        notices: list[str] = []
        ended: list[find.StopResult] = []
        if self._name:
            with contextlib.suppress(find.NoConsole):
                ended = find.stop({"to": self._name}, notices.append, _ASSISTANT)
        if all(answer.code == LOST for answer in ended):
            selection = {"to": self._to} if self._to else {}
            ended = find.stop(selection, notices.append, _ASSISTANT)
        answers = [{"code": answer.code, "text": answer.text} for answer in ended]
        answers[0]["text"] = "\n".join((answers[0]["text"], *notices))
        return answers

    def close(self) -> None:
        """Close the connection; a request without a result raises Unreached."""
        if self._console is not None:
            self._console.shut_down()
