"""A client that is generated from the committed openapi.json goes through the tutorial on a running service.

The generator, openapi-python-client, is no dependency of the project; give its command, from an environment of its own:

    python -m venv /tmp/generator && /tmp/generator/bin/pip install openapi-python-client
    python benchmarks/generated_client.py --generator /tmp/generator/bin/openapi-python-client
"""

import argparse
import subprocess
import sys
import tempfile
import time
import zlib
from importlib import import_module
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parent.parent
ENDED = ("done", "failed", "aborted", "cancelled")
PLANS: tuple[dict[str, Any], ...] = (
    {"kind": "impact", "points": [10, 6, 3], "hits": 5},
    {"kind": "sine"},
)


class Generated:
    """The generated package: every operation by its id, every document by its name."""

    def __init__(self, folder: Path, url: str, token: str) -> None:
        sys.path.insert(0, str(folder))
        self.client = import_module("modallab_client").AuthenticatedClient(
            base_url=url, token=token, raise_on_unexpected_status=True, timeout=60.0
        )
        self._models = import_module("modallab_client.models")
        self.calls = 0

    def document(self, name: str, content: dict[str, Any]) -> Any:
        return getattr(self._models, name).from_dict(content)

    def word(self, name: str, value: str) -> Any:
        """One of a list of values that the document names."""
        return getattr(self._models, name)(value)

    def __call__(self, tag: str, operation: str, *path: Any, **more: Any) -> Any:
        """Ask; what is no success is an error here."""
        self.calls += 1
        module = import_module(f"modallab_client.api.{tag}.{operation}")
        answer = module.sync_detailed(*path, client=self.client, **more)
        assert 200 <= int(answer.status_code) < 300, f"{operation}: {answer.status_code} {answer.content[:300]!r}"
        # A page for people is no document: it comes as it is.
        return answer.content if answer.parsed is None else answer.parsed


def generate(command: str, folder: Path) -> None:
    """Make the package; whatever the generator leaves out is an error."""
    document = ROOT / "docs" / "reference" / "openapi.json"
    order = [command, "generate", "--path", str(document), "--output-path", str(folder), "--overwrite"]
    said = subprocess.run(order, capture_output=True, text=True, check=True)
    assert "Warning parsing" not in said.stdout + said.stderr, said.stdout + said.stderr


def wait_for(ask: Any, *where: str) -> Any:
    """The last answer of an operation, once the run or the job has ended."""
    end = time.monotonic() + 1800
    while (found := ask(*where)).state not in ENDED:
        assert time.monotonic() < end, found
        time.sleep(0.5)
    assert found.state == "done", found
    return found


def every(lab: Generated, tag: str, operation: str, **more: Any) -> list[Any]:
    """All items of a list, page by page."""
    page = lab(tag, operation, **more)
    found = list(page.items)
    while page.next_:
        page = lab(tag, operation, cursor=page.next_, **more)
        found += page.items
    return found


def tutorial(lab: Generated) -> list[str]:
    """The pages of docs/tutorial/rest-service.md in their order; what was seen."""
    rig = lab("rigs", "list_rigs").items[0].id
    while lab("rigs", "get_rig", rig).state != "idle":
        time.sleep(0.2)
    new = lab.document("CampaignRequest", {"name": "first session", "rig": rig})
    campaign = lab("campaigns", "create_campaign", body=new, idempotency_key="generated-client").id
    held = lab("lease", "take_lease", rig, body=lab.document("LeaseRequest", {"operator": "Ada", "ttl_s": 3600}))
    lease = {"modallab_lease": held.id}
    runs: list[str] = []
    for plan in PLANS:
        begun = lab("runs", "start_run", campaign, body=lab.document("RunRequest", {"plan": plan}), **lease)
        wait_for(lambda run: lab("runs", "get_run", run), begun.id)
        runs.append(begun.id)
    impact, sine = runs
    events = every(lab, "events", "list_events", run=impact, limit=200)
    acknowledged = {e.content["n"]: e.content["crc32"] for e in events if e.kind == "block"}
    blocks = lab("blocks", "list_blocks", impact).items
    assert acknowledged == {block.n: block.crc32 for block in blocks}
    samples = lab("blocks", "get_samples", impact, blocks[0].n).payload.read()
    assert zlib.crc32(samples) == blocks[0].crc32
    hits = [block.n for block in blocks if block.accepted]
    before = lab("frf", "get_frf", impact).averages
    slip = {"accepted": False, "reason": "a slip"}
    lab("blocks", "put_verdict", impact, hits[1], body=lab.document("BlockVerdict", slip), **lease)
    after = lab("frf", "get_frf", impact).averages
    lab("blocks", "put_verdict", impact, hits[1], body=lab.document("BlockVerdict", {"accepted": True}), **lease)
    assert sum(before) - sum(after) == 1
    newest = lab("jobs", "list_campaign_jobs", campaign, kind=lab.word("ListCampaignJobsKind", "identify")).items[0].id
    wait_for(lambda job: lab("jobs", "get_job", job), newest)
    model = lab("results", "get_run_model", sine).models[0].model
    pages = {}
    for order, page in (("report", "get_report"), ("diagnose", "get_diagnosis")):
        job = lab("jobs", order, campaign, body=lab.document("JobRequest", {}))
        wait_for(lambda job: lab("jobs", "get_job", job), job.id)
        content = lab("jobs", page, campaign)
        pages[order] = len(content)
        assert "<html" in (content if isinstance(content, str) else content.decode())[:500].lower()
    gap = lab("results", "get_campaign_gap", campaign).diagnosis
    deeds = lab("events", "list_audit").items
    lab("lease", "release_lease", rig, **lease)
    assert lab("rigs", "stop_rig", rig, body=lab.document("StopReason", {})).trip is not None
    return [
        f"{len(blocks)} blocks of the hammer test, the first with its CRC-32",
        f"sine test: {', '.join(f'{f:.3f}' for f in model.frequency_hz)} Hz",
        f"pages of {pages['report']} and {pages['diagnose']} bytes, verdict {gap.verdict}",
        f"{len(deeds)} deeds on record",
    ]


def serve_and_ask(generator: Path) -> int:
    """A service, and the generated client in the generator's own environment, which has what it needs."""
    sys.path.insert(0, str(ROOT / "tests" / "helpers"))
    from service_process import ServiceProcess

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "client"
        generate(str(generator), folder)
        with ServiceProcess(Path(name) / "data") as service:
            order = [generator.with_name("python"), __file__, "--package", folder, "--url", service.url]
            return subprocess.run([*map(str, order), "--token", service.token], check=False).returncode


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--generator", type=Path, help="the command")
    parser.add_argument("--package", type=Path, help="ask with the package in this folder")
    parser.add_argument("--url")
    parser.add_argument("--token")
    arguments = parser.parse_args()
    if arguments.package is None:
        return serve_and_ask(arguments.generator)
    files = (arguments.package / "modallab_client" / "api").glob("*/*.py")
    operations = sum(file.name != "__init__.py" for file in files)
    lab = Generated(arguments.package, arguments.url, arguments.token)
    seen = tutorial(lab)
    print(f"{operations} operations generated; {lab.calls} calls, all as documented: {'; '.join(seen)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
