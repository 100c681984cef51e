"""The process that a test starts in place of `python ...`: hands itself to the loaded process.

Run by `python -S -I`, so it imports only modules that are built into the interpreter or tiny.
It passes its standard streams, environment and folder on, then ends as the forked process ended.
SIGTERM, SIGINT and SIGHUP are passed on; when this process is killed, so is the forked one.
"""

import _signal  # type: ignore[import-not-found]
import _socket
import os
import sys


def main(name: str, arguments: list[str]) -> None:
    """Run `python *arguments` by a fork of the process that listens on the abstract socket."""
    try:
        for descriptor in (0, 1, 2):
            os.fstat(descriptor)
    except OSError:  # a stream is closed: only a new interpreter starts like that
        os.execv(sys.executable, [sys.executable, *arguments])
    server = _socket.socket(_socket.AF_UNIX, _socket.SOCK_SEQPACKET)
    server.connect("\0" + name)
    request = repr((dict(os.environ), os.getcwd(), arguments, None)).encode()
    streams = b"".join(n.to_bytes(4, sys.byteorder) for n in (0, 1, 2))
    server.sendmsg([request], [(_socket.SOL_SOCKET, _socket.SCM_RIGHTS, streams)])
    forked = int(server.recv(100))
    for number in (_signal.SIGTERM, _signal.SIGINT, _signal.SIGHUP):
        _signal.signal(number, lambda number, _: os.kill(forked, number))
    for descriptor in (0, 1, 2):  # a pipe ends when the forked process closes it
        os.close(descriptor)
    status = int(server.recv(100))
    if os.WIFSIGNALED(status):
        _signal.signal(os.WTERMSIG(status), _signal.SIG_DFL)
        os.kill(os.getpid(), os.WTERMSIG(status))
    os._exit(os.waitstatus_to_exitcode(status))


main(sys.argv[1], sys.argv[2:])
