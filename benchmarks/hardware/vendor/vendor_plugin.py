"""Lets the vendor's tests use a server that runs already; theirs is found on one system only."""

import os
from typing import Any, Self

import grpc
import nidaqmx
import nidaqmx.system
from tests import _grpc_utils


class RunningServer:
    """Stands where the vendor's fixtures expect the process of a server."""

    def __init__(self) -> None:
        self.server_port = int(os.environ["NI_SERVER_PORT"])

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: Any) -> None:
        pass


_grpc_utils.GrpcServerProcess = RunningServer

# Some tests look at the local system while they are collected; there is none here.
_OPTIONS = nidaqmx.GrpcSessionOptions(grpc.insecure_channel(f"localhost:{os.environ['NI_SERVER_PORT']}"), "")
nidaqmx.system.System.local = staticmethod(lambda: nidaqmx.system.System.remote(_OPTIONS))
