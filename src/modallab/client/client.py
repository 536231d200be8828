"""The client: one method for each thing the service does."""

import time
import zlib
from collections.abc import Iterable, Iterator
from typing import Any

import httpx
import numpy as np
from numpy.typing import NDArray
from pydantic import JsonValue

from modallab.client.connection import AGAIN_S, HeldLease, require_good
from modallab.client.queue_and_user_calls import QueueCalls, UserCalls
from modallab.core.documents.models import ComparisonView, DiagnosisView, ModelsView
from modallab.core.documents.pages import EventView, Page
from modallab.core.documents.results import FrfView, JobKind, JobRequest, JobView
from modallab.core.documents.rigs import Lease, LeaseRequest, RigView, StopReason
from modallab.core.documents.runs import (
    BlockVerdict,
    BlockView,
    CampaignRequest,
    CampaignView,
    Command,
    RunRequest,
    RunView,
)
from modallab.core.plan import Plan

ENDED = ("done", "failed", "aborted")
ORDERS: dict[JobKind, str] = {"identify": "models", "diagnose": "diagnoses", "report": "reports"}
"""Kinds that are ordered of a campaign; an estimate is ordered of a run."""


class Client(QueueCalls, UserCalls):
    """A connection to one service. Every method raises `ServiceProblemError` for what the service rejects."""

    def rigs(self) -> tuple[RigView, ...]:
        """All rigs of the service."""
        return self._get(Page[RigView], "/rigs").items

    def rig(self, rig: str) -> RigView:
        """How a rig stands."""
        return self._get(RigView, f"/rigs/{rig}")

    def wait_until_idle(self, rig: str, patience_s: float = 60.0) -> RigView:
        """Wait until a rig's bench is open and no run is on.

        Raises:
            TimeoutError: not within `patience_s`.
        """
        end = time.monotonic() + patience_s
        while (view := self.rig(rig)).state != "idle":
            if time.monotonic() > end:
                raise TimeoutError(f"{rig} is still {view.state} after {patience_s:g} s: {view.error}")
            time.sleep(0.1)
        return view

    def processes(self) -> dict[str, int]:
        """The processes of the service that live, by name."""
        return self._send("GET", "/processes").json()

    def emergency_stop(self, rig: str, reason: str = "") -> RigView:
        """Bring the output of a rig to 0 V and latch it. Not a safety-rated stop."""
        return self._post(RigView, f"/rigs/{rig}/emergency-stop", StopReason(reason=reason))

    def reset_rig(self, rig: str, lease: HeldLease, reason: str = "") -> RigView:
        """Let a tripped rig be driven again."""
        return self._post(RigView, f"/rigs/{rig}/reset", StopReason(reason=reason), lease)

    def take_lease(
        self,
        rig: str,
        operator: str | None = None,
        ttl_s: float = 30.0,
        *,
        take_over: bool = False,
        recover: bool = False,
    ) -> HeldLease:
        """Take the lease of a rig; it is renewed until it is closed.

        Args:
            rig: its id.
            operator: who asks, with the service's own token; with a user's token it is that user.
            ttl_s: for so long, unless it is renewed.
            take_over: from whoever holds it, as long as no run is on; from yourself always.
            recover: the one you hold already.
        """
        new = LeaseRequest(operator=operator, ttl_s=ttl_s, take_over=take_over, recover=recover)
        lease = self._post(Lease, f"/rigs/{rig}/lease", new)
        return HeldLease(lease, self._renew, self._release)

    def create_campaign(self, name: str, rig: str, note: str = "") -> CampaignView:
        """Make a campaign on a rig."""
        return self._post(CampaignView, "/campaigns", CampaignRequest(name=name, rig=rig, note=note))

    def campaigns(self, *, archived: bool = False, deleted: bool = False) -> tuple[CampaignView, ...]:
        """All campaigns, the newest first; those that are archived or deleted only where they are asked for."""
        return tuple(self._all(CampaignView, "/campaigns", _query_for_hidden(archived=archived, deleted=deleted)))

    def runs(self, campaign: str, *, archived: bool = False, deleted: bool = False) -> tuple[RunView, ...]:
        """The runs of a campaign, the oldest first; archived or deleted ones only where they are asked for."""
        query = _query_for_hidden(archived=archived, deleted=deleted)
        return tuple(self._all(RunView, f"/campaigns/{campaign}/runs", query))

    def campaign(self, campaign: str) -> CampaignView:
        """A campaign and the names of its runs."""
        return self._get(CampaignView, f"/campaigns/{campaign}")

    def archive_campaign(self, campaign: str) -> CampaignView:
        """Leave a campaign out of lists."""
        return self._post(CampaignView, f"/campaigns/{campaign}/archive")

    def delete_campaign(self, campaign: str) -> CampaignView:
        """Delete a campaign with its runs; `purge_utc` says until when it can be restored."""
        return self._delete(CampaignView, f"/campaigns/{campaign}")

    def restore_campaign(self, campaign: str) -> CampaignView:
        """Have a campaign back that is archived or deleted."""
        return self._post(CampaignView, f"/campaigns/{campaign}/restore")

    def archive_run(self, run: str) -> RunView:
        """Leave a run out of lists, and out of what is made of its campaign unless it is named."""
        return self._post(RunView, f"/runs/{run}/archive")

    def delete_run(self, run: str) -> RunView:
        """Delete a run that has ended; `purge_utc` says until when it can be restored."""
        return self._delete(RunView, f"/runs/{run}")

    def restore_run(self, run: str) -> RunView:
        """Have a run back that is archived or deleted."""
        return self._post(RunView, f"/runs/{run}/restore")

    def start_run(self, campaign: str, plan: Plan | None, lease: HeldLease, continues: str | None = None) -> RunView:
        """Begin a run; without a plan, with what is left of the run it continues."""
        return self._post(RunView, f"/campaigns/{campaign}/runs", RunRequest(plan=plan, continues=continues), lease)

    def run(self, run: str) -> RunView:
        """A run as it stands."""
        return self._get(RunView, f"/runs/{run}")

    def command_run(self, run: str, command: Command, lease: HeldLease) -> RunView:
        """Send a command to an active run."""
        return self._post(RunView, f"/runs/{run}/commands", command, lease)

    def blocks(self, run: str) -> tuple[BlockView, ...]:
        """All blocks of a run, rejected ones with them."""
        return tuple(self._all(BlockView, f"/runs/{run}/blocks"))

    def samples(self, run: str, n: int) -> NDArray[Any]:
        """(channels, count) samples of a block as the device delivered them, checked against their CRC-32.

        Raises:
            ValueError: what arrived is not what was recorded.
        """
        response = self._send("GET", f"/runs/{run}/blocks/{n}/samples")
        if zlib.crc32(response.content) != int(response.headers["Modallab-Crc32"]):
            raise ValueError(f"block {n} of run {run} arrived damaged")
        shape = tuple(int(part) for part in response.headers["Modallab-Shape"].split(","))
        return np.frombuffer(response.content, response.headers["Modallab-Dtype"]).reshape(shape)

    def judge_block(self, run: str, n: int, verdict: BlockVerdict, lease: HeldLease | None = None) -> BlockView:
        """Accept or reject a block; while its run goes on that needs the lease."""
        path = f"/runs/{run}/blocks/{n}/verdict"
        return self._put(BlockView, path, verdict, lease)

    def frf(self, run: str) -> FrfView:
        """Mobility and coherence of the blocks that count now."""
        return self._get(FrfView, f"/runs/{run}/frf")

    def follow_run(self, run: str, after: int = 0) -> Iterator[EventView]:
        """The events of a run as they come, to its end; a connection that breaks is taken up where it was."""
        for event in self.follow_events(after, run):
            yield event
            if event.kind == "state" and event.content["state"] in ENDED:
                return

    def follow_events(self, after: int = 0, run: str = "") -> Iterator[EventView]:
        """All events as they come, for ever; a connection that breaks is taken up where it was."""
        while True:
            try:
                for event in self._stream(run, after):
                    after = event.seq
                    yield event
            except httpx.TransportError:
                time.sleep(AGAIN_S)

    def order_job(self, campaign: str, kind: JobKind, **parameters: JsonValue) -> JobView:
        """Order the model, the diagnosis or the report of a campaign."""
        return self._post(JobView, f"/campaigns/{campaign}/{ORDERS[kind]}", JobRequest(parameters=parameters))

    def order_blind_trials(self, **parameters: JsonValue) -> JobView:
        """Order blind trials of the diagnosis on simulated benches."""
        return self._post(JobView, "/blind-trials", JobRequest(parameters=parameters))

    def jobs(self, campaign: str, kind: JobKind | None = None) -> tuple[JobView, ...]:
        """The jobs of a campaign, the newest first."""
        query = {} if kind is None else {"kind": kind}
        return self._get(Page[JobView], f"/campaigns/{campaign}/jobs", query).items

    def job(self, job: str) -> JobView:
        """A job as it stands."""
        return self._get(JobView, f"/jobs/{job}")

    def wait_for_job(self, job: str, patience_s: float = 600.0) -> JobView:
        """Wait until a job has ended.

        Raises:
            TimeoutError: not within `patience_s`.
        """
        end = time.monotonic() + patience_s
        while (view := self.job(job)).state in ("queued", "running"):
            if time.monotonic() > end:
                raise TimeoutError(f"job {job} is still {view.state} after {patience_s:g} s")
            time.sleep(0.2)
        return view

    def models(self, campaign: str) -> ModelsView:
        """The newest models of a campaign."""
        return self._get(ModelsView, f"/campaigns/{campaign}/model")

    def diagnosis(self, campaign: str) -> DiagnosisView:
        """The newest diagnosis of a campaign."""
        return self._get(DiagnosisView, f"/campaigns/{campaign}/gap")

    def compare_runs(self, one: str, other: str) -> ComparisonView:
        """The models of two runs side by side."""
        return self._get(ComparisonView, "/comparison", {"one": one, "other": other})

    def report(self, campaign: str) -> str:
        """The newest report of a campaign, as HTML."""
        return self._send("GET", f"/campaigns/{campaign}/report").text

    def _stream(self, run: str, after: int) -> Iterator[EventView]:
        patience = httpx.Timeout(30.0)
        query = {"run": run, "after": str(after)}
        with self._http.stream("GET", "/events/stream", params=query, timeout=patience) as response:
            if not response.is_success:
                response.read()
            require_good(response)
            yield from read_events(response.iter_lines())

    def _renew(self, lease: Lease) -> None:
        self._send("PUT", f"/rigs/{lease.rig}/lease", None, lease)

    def _release(self, lease: Lease) -> None:
        self._send("DELETE", f"/rigs/{lease.rig}/lease", None, lease)


def read_events(lines: Iterable[str]) -> Iterator[EventView]:
    """The events in a stream of lines (WHATWG HTML, 9.2.6)."""
    data: list[str] = []
    for line in lines:
        if not line:
            if data:
                yield EventView.model_validate_json("\n".join(data))
            data = []
        elif line.startswith("data:"):
            data.append(line[5:].removeprefix(" "))


def _query_for_hidden(*, archived: bool, deleted: bool) -> dict[str, str]:
    """The query that lists what is hidden otherwise."""
    return {name: "true" for name, wanted in (("archived", archived), ("deleted", deleted)) if wanted}
