"""Runs one of the vendor's examples against a server: `launcher.py host:port example.py`.

The examples name no server, so each task and each look at the system is given one.
"""

import runpy
import sys
from typing import Any

import grpc
import nidaqmx
import nidaqmx.system


def direct(target: str) -> None:
    """Let every task and every local system of this process speak to a server."""
    options = nidaqmx.GrpcSessionOptions(grpc.insecure_channel(target), "")
    begin = nidaqmx.Task.__init__

    def remote(self: Any, new_task_name: str = "", *, grpc_options: Any = None) -> None:
        begin(self, new_task_name, grpc_options=grpc_options or options)

    nidaqmx.Task.__init__ = remote
    nidaqmx.system.System.local = staticmethod(lambda: nidaqmx.system.System.remote(options))


if __name__ == "__main__":
    direct(sys.argv[1])
    sys.argv = sys.argv[2:]
    runpy.run_path(sys.argv[0], run_name="__main__")
