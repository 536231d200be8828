"""A process that has imported a program, and forks one for each that a test wants: its imports take longest."""

import json
import os
import signal
import socket
import subprocess
import sys
from functools import cache
from typing import NoReturn

SERVE = "import sys, warm_process; warm_process.serve(sys.argv[1], int(sys.argv[2]))"
LONGEST = 65536
"""Of a command, bytes."""


class WarmProcess:
    """Programs of one module, each a process of its own with pipes to it."""

    def __init__(self, module: str) -> None:
        self._ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        command = [sys.executable, "-c", SERVE, module, str(theirs.fileno())]
        path = os.pathsep.join(filter(None, (os.path.dirname(__file__), os.environ.get("PYTHONPATH"))))
        self._process = subprocess.Popen(
            command, pass_fds=(theirs.fileno(),), env={**os.environ, "PYTHONPATH": path}, stdin=subprocess.DEVNULL
        )
        theirs.close()

    def start(self, arguments: list[str], stdin: int, stdout: int) -> int:
        """Run the module's `main` on arguments and two descriptors; the number of the process."""
        socket.send_fds(self._ours, [json.dumps(arguments).encode()], [stdin, stdout])
        return int(self._ours.recv(LONGEST))


@cache
def warm(module: str) -> WarmProcess:
    """The one of a module, which ends with the tests."""
    return WarmProcess(module)


def serve(module: str, descriptor: int) -> None:
    """Fork until nobody asks any more."""
    main = __import__(module, fromlist=["main"]).main
    asked = socket.socket(fileno=descriptor)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    while True:
        message, descriptors, *_ = socket.recv_fds(asked, LONGEST, 2)
        if not message:
            return
        pid = os.fork()
        if pid == 0:
            asked.close()
            _become(module, main, json.loads(message), descriptors)
        for one in descriptors:
            os.close(one)
        asked.send(str(pid).encode())


def _become(module: str, main, arguments: list[str], descriptors: list[int]) -> NoReturn:
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    for number, one in enumerate(descriptors):
        os.dup2(one, number)
        os.close(one)
    sys.argv = [module, *arguments]
    code = 1
    try:
        code = main()
    finally:
        sys.stdout.flush()
        os._exit(code)
