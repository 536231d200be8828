"""The supervisor is killed at any moment of starting: nothing of it lives on, and its port is free for the next."""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from service_process import COMMAND, ServiceProcess

from modallab.core.errors import ModallabError
from modallab.service.process.child_processes import ProcessList
from modallab.service.process.connections import bound_socket

MOMENTS_S = (0.7, 1.2, 1.8, 2.5, 4.0)
GONE_S = 15.0


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def serve(data: Path, port: int) -> "subprocess.Popen[bytes]":
    command = [COMMAND, "serve", "--data", data, "--port", str(port), "--stop-port", "0", "--workers", "1"]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


@pytest.mark.thorough("kills processes of a running service")
def test_no_process_outlives_the_supervisor_and_its_port_is_free_again(tmp_path: Path) -> None:
    port, data = free_port(), tmp_path / "data"
    for moment_s in MOMENTS_S:
        supervisor = serve(data, port)
        time.sleep(moment_s)
        of_it = psutil.Process(supervisor.pid).children(recursive=True)
        assert supervisor.poll() is None, "it could not start"
        supervisor.kill()
        supervisor.wait()
        _, left = psutil.wait_procs(of_it, timeout=GONE_S)
        assert left == []
    with ServiceProcess(data, "--port", str(port), "--no-jobs") as service:
        assert service.url.endswith(str(port))


@pytest.mark.thorough("kills processes of a running service")
def test_a_frozen_rest_process_goes_with_its_supervisor(tmp_path: Path) -> None:
    with ServiceProcess(tmp_path / "data", "--no-jobs") as service:
        api = psutil.Process(service.client.processes()["api"])
        os.kill(api.pid, signal.SIGSTOP)
        service.process.kill()
        service.process.wait()
        assert psutil.wait_procs([api], timeout=GONE_S)[1] == []


def test_what_is_left_of_an_earlier_service_of_the_folder_is_ended(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as left:
        ProcessList(tmp_path).add("api", left.pid)
        assert ProcessList(tmp_path).end_all() == (left.pid,)
        assert not psutil.pid_exists(left.pid)
    assert ProcessList(tmp_path).end_all() == ()


def test_a_rigs_process_of_an_earlier_service_may_leave_by_itself(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", "import time; time.sleep(0.3)"]) as left:
        ProcessList(tmp_path).add("rig link", left.pid, leaves=True)
        assert ProcessList(tmp_path).end_all() == ()
        assert left.wait(5) == 0


def test_a_frozen_rigs_process_of_an_earlier_service_is_ended(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as left:
        ProcessList(tmp_path).add("rig link", left.pid, leaves=True)
        os.kill(left.pid, signal.SIGSTOP)
        while psutil.Process(left.pid).status() != psutil.STATUS_STOPPED:
            time.sleep(0.01)
        assert ProcessList(tmp_path).end_all() == (left.pid,)


def test_who_holds_the_port_is_said() -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        with pytest.raises(ModallabError, match=f"process {os.getpid()} holds it"):
            bound_socket("127.0.0.1", other.getsockname()[1])
