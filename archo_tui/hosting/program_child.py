"""A program on ROS 2: a child process, whose nodes are on the graph like those of any other."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import IO, Any

from archo_tui.hosting.hosted_program import HostedProgram, Program, ProgramEnd
from archo_tui.hosting.node_output import NodeOutput

assert sys.platform != "win32"  # As mypy is to know: signals and inherited files are of POSIX.


class ProgramChild(HostedProgram):
    """A program in a child process, without a standard input."""

    def __init__(self, program: Program, *callbacks: Any, output: NodeOutput) -> None:
        """Create the hosted program.

        Args:
            program: The program to run.
            *callbacks: The callbacks of `HostedProgram`.
            output: Gets the lines that the program prints, in threads named like its node.
        """
        super().__init__(program, *callbacks)
        self._output = output
        self._process: subprocess.Popen[str] | None = None
        self._names: list[str] = []
        self._lock = threading.Lock()  # Around the start of the process, which a stop may meet.

    def run_once(self) -> ProgramEnd:
        with self._lock:
            if self.is_stopping:
                return ProgramEnd(0)
            process, reports, answers = self._started()
            self._process = process
        streams = [process.stdout, process.stderr]
        printers = [
            threading.Thread(target=self._write_lines, args=(stream,), name=self.name, daemon=True)
            for stream in streams
        ]
        threading.Thread(target=_end_group, args=(process,), daemon=True).start()
        for printer in printers:
            printer.start()
        end: dict[str, Any] = {}
        with reports, answers:
            for line in reports:
                report = json.loads(line)
                if "node" in report:
                    self.file.imported.update(map(Path, report["imported"]))
                    may_go_on = self.accept_node(report["node"])
                    if may_go_on:
                        self._names.append(report["node"])
                    for printer in printers:
                        printer.name = self.name
                    with contextlib.suppress(BrokenPipeError):  # It has ended by now.
                        print(json.dumps(may_go_on), file=answers, flush=True)
                elif "serves" in report:
                    self.served = tuple(report["serves"])
                else:
                    end = report
        code = process.wait()
        for printer in printers:
            printer.join()
        self._names.clear()
        if code < 0:
            end = {"error": f"{self.file}: ended by {signal.Signals(-code).name}"}
        return ProgramEnd(code, end.get("error", ""), end.get("traceback", ""))

    def _started(self) -> tuple[subprocess.Popen[str], IO[str], IO[str]]:
        """Start the process; return it, the stream of its reports and that of their answers."""
        receiver, sender = os.pipe()
        heard, answerer = os.pipe()
        environment = dict(os.environ)
        if self.program.domain_id is not None:
            environment["ROS_DOMAIN_ID"] = str(self.program.domain_id)
        runner = [sys.executable, "-m", "archo_tui.hosting.run_program", str(sender), str(heard)]
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
        return process, reports, os.fdopen(answerer, "w", encoding="utf-8")

    def node_names(self) -> tuple[str, ...]:
        return tuple(self._names)

    def serves_now(self) -> tuple[str, ...]:
        return self.served  # As it has reported.

    def is_at_rest(self) -> bool:
        return self.has_name

    def interrupt(self) -> None:
        self._signal(signal.SIGINT)

    def force_end(self) -> None:
        self._signal(signal.SIGKILL)

    def _write_lines(self, stream: IO[str]) -> None:
        """Copy a stream of the program to the output, in a thread that is named like its node."""
        with stream:
            for line in stream:
                self._output.write(line)

    def _signal(self, number: int) -> None:
        with self._lock, contextlib.suppress(ProcessLookupError):
            if self._process is not None and self._process.returncode is None:
                os.killpg(self._process.pid, number)  # What it has started in its turn, too.


def _end_group(process: subprocess.Popen[str]) -> None:
    """Wait for the end of a process, then kill its group: children may hold its output open."""
    process.wait()
    with contextlib.suppress(ProcessLookupError):  # No other process gets the id of a group.
        os.killpg(process.pid, signal.SIGKILL)
