"""Kills any process of the service, or any two at once, at any moment of start, run and stop.

The client is one of its own, made of the standard library, as anyone would write it: it asks again under the same
idempotency key when an answer is lost, and knows nothing of the project's code. After each kill: the service is good
again within 15 s (it is started again by hand only where its supervisor is dead); every block that was acknowledged is
there with its CRC-32; no key has begun two runs; no process of it is left behind.

    python benchmarks/kill_anything.py --kills 300
"""

import argparse
import json
import os
import random
import secrets
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
import zlib
from contextlib import suppress
from pathlib import Path
from typing import Any

import psutil

LIMIT_S = 15.0
WEDGED_S = 90.0
BENCH = "sim://cantilever?seed=1&zeta=0.05&bad_hits=0"
IMPACT = {"kind": "impact", "points": [10, 6, 3], "hits": 12}
SINE = {"kind": "sine", "frequencies_hz": [19.0, 20.0, 21.0], "settle_s": 1.0, "ramp_s": 0.3, "wait_s": 0.5}
ENDED = ("done", "failed", "aborted")
MOMENTS = ("start", "run", "run", "stop")
LOST = (OSError, urllib.error.URLError, ValueError)


class Service:
    """The command, and plain requests to it."""

    def __init__(self, folder: Path) -> None:
        self.data = folder / "data"
        self.port, self.stop_port = free_port(), free_port()
        self.log = (folder / "log").open("ab")
        self.process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        command = [str(Path(sys.executable).with_name("modallab")), "serve", "--data", str(self.data)]
        command += ["--port", str(self.port), "--stop-port", str(self.stop_port), "--workers", "1", "--bench", BENCH]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=self.log)

    def tree(self) -> list[psutil.Process]:
        assert self.process is not None
        with suppress(psutil.Error):
            root = psutil.Process(self.process.pid)
            return [root, *root.children(recursive=True)]
        return []

    @property
    def dead(self) -> bool:
        return self.process is None or self.process.poll() is not None

    def ask(self, method: str, path: str, body: Any = None, **headers: str) -> Any:
        token = (self.data / "token").read_text().strip()
        sent = {"Authorization": f"Bearer {token}", "Modallab-Operator": "killer"}
        sent |= {name.replace("_", "-"): value for name, value in headers.items()}
        content = None if body is None else json.dumps(body).encode()
        if content is not None:
            sent["Content-Type"] = "application/json"
        request = urllib.request.Request(f"http://127.0.0.1:{self.port}{path}", content, sent, method=method)
        with urllib.request.urlopen(request, timeout=10) as answer:
            found = answer.read()
            return json.loads(found) if answer.headers["Content-Type"] == "application/json" else found

    def again(self, method: str, path: str, body: Any = None, **headers: str) -> Any:
        """Ask until there is an answer; under the same key it is done once. What is rejected is raised."""
        end = time.monotonic() + WEDGED_S
        while True:
            try:
                return self.ask(method, path, body, **headers)
            except LOST as error:
                rejected = isinstance(error, urllib.error.HTTPError) and error.code not in (500, 503)
                if rejected or time.monotonic() > end:
                    raise
                time.sleep(0.1)

    def good(self) -> bool:
        with suppress(*LOST):
            return self.ask("GET", "/health")["status"] == "good"
        return False


class Killer:
    """Kills, and keeps what was acknowledged."""

    def __init__(self, service: Service, moment: random.Random) -> None:
        self.service, self.moment = service, moment
        self.blocks: dict[tuple[str, int], int] = {}
        self.begun: dict[str, str] = {}
        self.cursor = 0

    def round(self) -> tuple[str, float]:
        """One kill; what and when, and seconds until the service was good again."""
        service, when = self.service, self.moment.choice(MOMENTS)
        if when == "start":
            self._end()
            service.start()
            time.sleep(self.moment.uniform(0.0, 4.0))
        else:
            self._begin()
            time.sleep(self.moment.uniform(0.0, 2.0))
            self._read_events()
            if when == "stop":
                assert service.process is not None
                service.process.send_signal(signal.SIGTERM)
                time.sleep(self.moment.uniform(0.0, 1.5))
        tree = service.tree()
        chosen = self.moment.sample(tree, min(len(tree), self.moment.choice((1, 1, 2))))
        names = [role(process, service) for process in chosen]
        for process in chosen:
            with suppress(psutil.Error):
                process.kill()
        took = self._until_good(time.monotonic(), leaves=when == "stop")
        left = [process for process in tree if process.is_running() and process not in service.tree()]
        _, left = psutil.wait_procs(left, timeout=LIMIT_S)
        assert not left, f"{left} live on"
        self._check()
        return f"{when}: {' and '.join(names) or 'nothing left to kill'}", took

    def _until_good(self, began: float, *, leaves: bool) -> float:
        service = self.service
        while leaves and not service.dead:
            assert time.monotonic() - began < WEDGED_S, "it does not leave"
            time.sleep(0.02)
        # A kill is not seen at once; what is good only until it is would be measured as nothing.
        time.sleep(0.5)
        while not service.good():
            if service.dead:
                service.start()
            assert time.monotonic() - began < WEDGED_S, "wedged"
            time.sleep(0.1)
        return time.monotonic() - began

    def _begin(self) -> None:
        service = self.service
        if service.dead:
            service.start()
        self._until_good(time.monotonic(), leaves=False)
        rig = service.again("GET", "/api/v1/rigs")["items"][0]
        lease = service.again(
            "POST", f"/api/v1/rigs/{rig['id']}/lease", {"operator": "killer", "ttl_s": 600, "take_over": True}
        )["id"]
        if rig["trip"] is not None:
            service.again("POST", f"/api/v1/rigs/{rig['id']}/reset", {"reason": "seen"}, Modallab_Lease=lease)
        new = {"name": f"kill {len(self.begun)}", "rig": rig["id"]}
        campaign = service.again("POST", "/api/v1/campaigns", new, Idempotency_Key=secrets.token_hex(8))["id"]
        plan = {"plan": self.moment.choice((IMPACT, IMPACT, SINE))}
        run = service.again(
            "POST",
            f"/api/v1/campaigns/{campaign}/runs",
            plan,
            Modallab_Lease=lease,
            Idempotency_Key=secrets.token_hex(8),
        )["id"]
        self.begun[campaign] = run

    def _end(self) -> None:
        if not self.service.dead:
            self.service.process.terminate()  # type: ignore[union-attr]
            self.service.process.wait(30)  # type: ignore[union-attr]

    def _read_events(self) -> None:
        with suppress(*LOST):
            while True:
                path = f"/api/v1/events?limit=500&cursor={encoded(self.cursor)}"
                page = self.service.ask("GET", path)["items"]
                for event in page:
                    self.cursor = event["seq"]
                    if event["kind"] == "block":
                        self.blocks[event["run"], event["content"]["n"]] = event["content"]["crc32"]
                if not page:
                    return

    def _check(self) -> None:
        """The newest runs have ended, are one each, and have what was acknowledged of them."""
        for campaign, run in list(self.begun.items())[-1:]:
            end = time.monotonic() + WEDGED_S
            while self.service.again("GET", f"/api/v1/runs/{run}")["state"] not in ENDED:
                assert time.monotonic() < end, f"run {run} does not end"
                time.sleep(0.1)
            assert self.service.again("GET", f"/api/v1/campaigns/{campaign}")["runs"] == [run], "a run twice"

    def check_all(self) -> None:
        """Every acknowledged block of every run, byte by byte."""
        self._read_events()
        for (run, n), crc32 in self.blocks.items():
            samples = self.service.again("GET", f"/api/v1/runs/{run}/blocks/{n}/samples")
            assert zlib.crc32(samples) == crc32, f"block {n} of {run} is not what was acknowledged"


def role(process: psutil.Process, service: Service) -> str:
    """Which of them it is, as far as can be seen from outside."""
    assert service.process is not None
    if process.pid == service.process.pid:
        return "supervisor"
    try:
        with suppress(*LOST):
            names = {pid: name for name, pid in service.ask("GET", "/api/v1/processes").items()}
            if process.pid in names:
                return names[process.pid]
        return "tracker" if "resource_tracker" in " ".join(process.cmdline()) else "another"
    except psutil.Error:
        return "gone"


def encoded(number: int) -> str:
    import base64

    return base64.urlsafe_b64encode(str(number).encode()).decode()


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    took: list[float] = []
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        service = Service(Path(folder))
        killer = Killer(service, random.Random(arguments.seed))
        try:
            for n in range(1, arguments.kills + 1):
                what, seconds = killer.round()
                took.append(seconds)
                print(f"{n} of {arguments.kills}: {what}: {seconds:.1f} s", flush=True)
            killer.check_all()
        except Exception:
            print((Path(folder) / "log").read_text(encoding="utf-8", errors="replace")[-6000:], file=sys.stderr)
            raise
        finally:
            if not service.dead and service.process is not None:
                service.process.terminate()
                service.process.wait(30)
    late = sum(t > LIMIT_S for t in took)
    median = sorted(took)[len(took) // 2]
    print(
        f"{len(took)} kills: {len(took) - late} good again within {LIMIT_S:g} s, median {median:.1f} s, longest"
        f" {max(took):.1f} s; {len(killer.begun)} runs, none twice; {len(killer.blocks)} acknowledged blocks, all there"
    )
    return 1 if late else 0


if __name__ == "__main__":
    sys.exit(main())
