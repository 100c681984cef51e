"""A program on ROS 2: a child process, whose nodes are on the graph like those of any other."""

from __future__ import annotations

import contextlib
import io
import json
import os
import queue
import secrets
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any, TextIO

from archo_tui.user_code.output import MAX_LENGTH
from archo_tui.user_code.program import Callbacks, HostedProgram, Program, ProgramEnd
from archo_tui.user_code.usage import Usage, of_process

assert sys.platform != "win32"  # As mypy is to know: signals and inherited files are of POSIX.

from archo_tui.user_code.child_main import MARK, kill_marked  # noqa: E402

_LAST_OUTPUT = 2.0  # Seconds in which what an ended process has printed is read.
_ANSWER_TIME = 2.0  # Seconds in which the child answers a question.


class ProgramChild(HostedProgram):
    """A program in a child process, without a standard input; docs of the pipes: `child_main`."""

    def __init__(
        self,
        program: Program,
        callbacks: Callbacks,
        is_held: bool = False,
        *,
        output: TextIO | io.TextIOBase,
    ) -> None:
        """Create the hosted program, whose printed lines go to `output`."""
        super().__init__(program, callbacks, is_held)
        self._output = output
        self._process: subprocess.Popen[str] | None = None
        self._requests: IO[str] | None = None
        self._answers: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._names: list[str] = []
        self._lock = threading.Lock()  # Around the start of the process, which a stop may meet.
        self._asking = threading.Lock()
        self._asked = 0
        self._mark = secrets.token_hex(8)

    def run_once(self) -> ProgramEnd:
        with self._lock:
            if self.is_stopping:
                return ProgramEnd(0)
            process, reports, self._requests = self._started()
            self._process = process
        printers = [
            threading.Thread(target=self._write_lines, args=(stream,), name=self.name, daemon=True)
            for stream in (process.stdout, process.stderr)
        ]
        group = threading.Thread(target=self._end_group, name="group", daemon=True)
        group.start()
        for printer in printers:
            printer.start()
        end: dict[str, Any] = {}
        with reports, self._requests:
            for line in reports:
                report = json.loads(line)
                if "error" in report:
                    end = report
                else:
                    self._take(report)
                for printer in printers:
                    printer.name = self.name
        code = process.wait()
        group.join()
        for printer in printers:
            printer.join(_LAST_OUTPUT)  # What left its group may hold the output open for ever.
        self._names.clear()
        return ProgramEnd(code, end.get("error", ""), end.get("traceback", ""))

    def _take(self, report: dict[str, Any]) -> None:
        """Take a report of the child, and answer where it waits for that."""
        if "init" in report:
            self.file.imported.update(map(Path, report["init"]))
            self._send(go_on=self.begin_context())
        elif "node" in report:
            name = report["node"]
            may_go_on = self.accept_node(name)
            if may_go_on:
                self._names.append(name)
            values = dict(self.callbacks.operator_values(name)) if may_go_on else {}
            self._send(go_on=may_go_on, values=values)
        elif "serves" in report:
            self.served = tuple(report["serves"])
        elif "answer" in report:
            self._answers.put(report)
        else:
            self.take_report(report)

    def _send(self, **request: Any) -> None:
        with contextlib.suppress(OSError, ValueError):  # It has ended by now.
            print(json.dumps(request), file=self._requests, flush=True)

    def ask(self, request: Mapping[str, Any]) -> dict[str, Any]:
        with self._asking, contextlib.suppress(queue.Empty):
            self._asked += 1
            self._send(**request, number=self._asked)
            end = time.monotonic() + _ANSWER_TIME
            while True:
                answer = self._answers.get(timeout=max(end - time.monotonic(), 0.0))
                if answer["number"] == self._asked:  # It may be a late one.
                    return dict(answer["answer"])
        return {}

    def _started(self) -> tuple[subprocess.Popen[str], IO[str], IO[str]]:
        """Start the process; return it, the stream of its reports and that of its requests."""
        receiver, sender = os.pipe()
        heard, requester = os.pipe()
        environment = {**os.environ, MARK: self._mark}
        if self.program.domain_id is not None:
            environment["ROS_DOMAIN_ID"] = str(self.program.domain_id)
        runner = [sys.executable, "-m", "archo_tui.user_code.child_main", str(sender), str(heard)]
        try:
            process = subprocess.Popen(
                [*runner, str(self.file), *self.program.arguments, *self.program.ros_args],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                errors="replace",
                env=environment | {"PYTHONUNBUFFERED": "1"},
                pass_fds=[sender, heard],
                start_new_session=True,  # Ctrl-C at the terminal is the console's.
            )
        finally:
            os.close(sender)
            os.close(heard)
        reports = os.fdopen(receiver, encoding="utf-8", errors="replace")
        return process, reports, os.fdopen(requester, "w", encoding="utf-8")

    def node_names(self) -> tuple[str, ...]:
        return tuple(self._names)

    def usage(self) -> Usage | None:
        process = self._process
        return None if process is None else of_process(process.pid)

    def serves_now(self) -> tuple[str, ...]:
        return self.served  # As it has reported.

    def is_at_rest(self) -> bool:
        return self._has_node

    def interrupt(self) -> None:
        self._signal(signal.SIGINT)

    def force_end(self) -> None:
        self._signal(signal.SIGKILL)

    def _write_lines(self, stream: IO[str]) -> None:
        """Copy a stream of the program to the output, in a thread that is named like its node."""
        last = "\n"
        with stream:
            while line := stream.readline(MAX_LENGTH):
                self._output.write(last := line)
        if not last.endswith("\n"):
            self._output.write("\n")

    def _signal(self, number: int) -> None:
        with self._lock, contextlib.suppress(ProcessLookupError):
            if self._process is not None and self._process.returncode is None:
                os.killpg(self._process.pid, number)  # What it has started in its turn, too.

    def _end_group(self) -> None:
        """Wait for the end of the process, then kill all it has started, which may hold pipes."""
        assert self._process is not None
        self._process.wait()
        with contextlib.suppress(ProcessLookupError):  # No other process gets the id of a group.
            os.killpg(self._process.pid, signal.SIGKILL)
        left = kill_marked(self._mark)
        if left:
            ids = ", ".join(map(str, left))
            text = f"has ended, but not what it has started: end process {ids} yourself"
            self.callbacks.on_event("ERROR", self.name.lstrip("/"), text)
