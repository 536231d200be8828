"""The blocks of the how-to pages that ask a service are run against one: in a shell, or as Python."""

import os
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from lab import RIG, TOKEN, Lab
from pages import HOW_TO, PAGES, ROOT, Fenced, fenced, name, needs_service, to_run
from twin_campaign import built

from modallab.client import Client
from modallab.core.documents.runs import RunRequest, StopRun
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Rig
from modallab.formats import write_export
from modallab.service.campaigns.run_start import begin_run

TUTORIAL = "docs/tutorial/rest-service.md"
ADDRESS = "http://127.0.0.1:8000"


def _blocks(page: Path) -> list[Fenced]:
    return [b for b in to_run(page) if not b.not_run and needs_service(b)]


ASKING = [page for page in PAGES if _blocks(page) and name(page) != TUTORIAL]


class Reader:
    """Somebody with a shell and Python beside a running service; has followed the tutorial so far.

    Args:
        lab: the service.
        folder: where he works; `lab-data` in it is the service's.
        rig: what stands on the bench.
    """

    def __init__(self, lab: Lab, folder: Path, rig: Rig) -> None:
        self.lab, self.folder = lab, folder
        (folder / "lab-data").mkdir(exist_ok=True)
        (folder / "lab-data/token").write_text(TOKEN, encoding="utf-8")
        write_export(built(rig, tests=("impact",)), folder / "export.uff", "uff")
        self.variables: dict[str, str] = {"RIG": RIG}
        self.names: dict[str, Any] = {"rig": RIG, "token": TOKEN, "admin_token": TOKEN}

    def run(self, block: Fenced) -> None:
        """Run a block; what it sets is there for the next one."""
        text = "\n".join(block.lines).replace(ADDRESS, self.lab.url)
        if block.language in {"py", "python"}:
            exec(compile(text, block.place, "exec"), self.names)
            return
        functions = "\n".join(fenced(ROOT / TUTORIAL)[1].lines).replace(ADDRESS, self.lab.url)
        script = f'set -e\n{functions}\n{text}\nprintf %s "$LEASE" > lease\n'
        done = subprocess.run(
            ["bash", "-c", script], cwd=self.folder, env=os.environ | self.variables, capture_output=True, text=True,
            check=False,
        )  # fmt: skip
        assert done.returncode == 0, f"{block.place}: {done.stdout[-2000:]}{done.stderr[-2000:]}"
        self.variables["LEASE"] = (self.folder / "lease").read_text(encoding="utf-8")

    def give_back(self) -> None:
        """Whoever holds the lease gives it back."""
        leases = self.lab.service.leases
        leases.release(RIG, leases.take(RIG, "Ada", 1.0, take_over=True).id)

    def record(self) -> None:
        """A run that was stopped after its first hit, by him who holds the lease."""
        service = self.lab.service
        lease = self.lab.lease()
        # So many that on a busy machine, too, it is stopped before it has them all.
        plan = RunRequest(plan=ImpactPlan(points=(10,), hits=8))
        run = begin_run(service, self.variables["CAMPAIGN"], plan, lease.id)
        self.lab.wait_for(lambda e: e.run == run and e.kind == "block")
        self.lab.controllers.command(RIG, run, StopRun(), lease.id)
        self.lab.wait_for_ended(run)
        self.variables |= {"RUN": run, "LEASE": lease.id}


@pytest.fixture
def reader(lab: Lab, tmp_path: Path, link_rig: Rig, monkeypatch: pytest.MonkeyPatch) -> Iterator[Reader]:
    monkeypatch.chdir(tmp_path)
    reader = Reader(lab, tmp_path, link_rig)
    reader.variables["CAMPAIGN"] = reader.names["campaign"] = lab.campaign()
    yield reader
    reader.give_back()
    # A page need not say how a program ends.
    for left in reader.names.values():
        if isinstance(left, Client):
            left.close()


@pytest.mark.thorough("runs all blocks of the pages that ask a service")
@pytest.mark.parametrize("page", ASKING, ids=name)
def test_every_block_that_asks_a_service_is_answered(page: Path, reader: Reader) -> None:
    BEFORE.get(name(page), Reader.record)(reader)
    for block in _blocks(page):
        reader.lab.wait_until_idle()
        if "/reset" in "\n".join(block.lines):
            reader.lab.controllers.emergency_stop(RIG, "a cable", "Ada")
        if '"recover"' in "\n".join(block.lines):
            reader.lab.lease()
        if block.language in {"py", "python"}:
            # A program takes the lease itself.
            reader.give_back()
        reader.run(block)
    reader.lab.wait_until_idle()


def _deleted(reader: Reader) -> None:
    """The campaign was deleted."""
    with reader.lab.client() as client:
        client.delete(f"/api/v1/campaigns/{reader.variables['CAMPAIGN']}").raise_for_status()


def _nothing(reader: Reader) -> None:
    """He needs no run."""


BEFORE: dict[str, Callable[[Reader], None]] = {
    HOW_TO + "import-recordings.md": _nothing,
    HOW_TO + "keep-data-safe.md": _deleted,
    HOW_TO + "let-people-in.md": _nothing,
    HOW_TO + "queue-runs.md": _nothing,
}
