"""The service within the test's own process: the same rules and application, with a real rig process behind."""

import secrets
import time
from collections.abc import Callable
from pathlib import Path
from threading import Thread
from typing import Self

import httpx
import uvicorn

from modallab.core.documents.pages import EventView
from modallab.core.documents.rigs import Lease
from modallab.core.documents.runs import CampaignRequest
from modallab.core.events import RunState
from modallab.core.rig import Rig
from modallab.core.settings import Settings
from modallab.jobs import Jobs
from modallab.service.api.app import create_app
from modallab.service.context import Service, open_service
from modallab.service.jobs.background import IdentificationAfterRun
from modallab.service.process.connections import bound_socket
from modallab.service.records.event_log import EventLog
from modallab.service.records.leases import RigLeases
from modallab.service.rigs.controller import RigController, ServedRig
from modallab.service.rigs.controllers import RigControllers
from modallab.service.rigs.run_log import RunLog
from modallab.storage import Store
from modallab.storage.records import ENDED

TOKEN = "a token for tests only"
RIG = "link"


class Lab:
    """One rig, its controller, and the service over them."""

    def __init__(self, folder: Path, rig: Rig, url: str) -> None:
        boot = secrets.token_hex(4)
        self.store = Store(folder)
        engine = self.store.catalogue.engine
        run_log = self.run_log = RunLog(self.store, EventLog(engine, self._new_events))
        after = IdentificationAfterRun(self.store, Jobs(engine))
        # On a busy machine the rig's process takes minutes to open its bench.
        self.controller = RigController(ServedRig(RIG, rig, url, folder), run_log, after, begin_s=240.0)
        self.controllers = RigControllers([self.controller], RigLeases(engine, boot))
        self.service: Service = open_service(folder, self.controllers, boot)
        self.app = create_app(self.service, Settings(data=folder, body_bytes=4096), TOKEN)
        listener = bound_socket("127.0.0.1", 0)
        self.url = f"http://127.0.0.1:{listener.getsockname()[1]}"
        self._server = uvicorn.Server(
            uvicorn.Config(self.app, log_config=None, ws="websockets-sansio", timeout_graceful_shutdown=1)
        )
        self._serving = Thread(target=self._server.run, kwargs={"sockets": [listener]}, daemon=True)
        self._serving.start()

    def _new_events(self) -> None:
        if hasattr(self, "app"):
            self.app.state.feed.check_now()

    def client(self, token: str | None = TOKEN) -> httpx.Client:
        """Who asks over HTTP; to be entered as a context."""
        headers = {} if token is None else {"Authorization": f"Bearer {token}"}
        return httpx.Client(base_url=self.url, headers=headers, timeout=60.0)

    def lease(self, operator: str = "Ada") -> Lease:
        """The rig's lease."""
        return self.service.leases.take(RIG, operator, 600.0)

    def campaign(self, name: str = "a session") -> str:
        """A new campaign's id."""
        return self.service.repository.create(CampaignRequest(name=name, rig=RIG), "Ada").id

    def wait_for(self, happened: Callable[[EventView], bool], after: int = 0, within_s: float = 240.0) -> EventView:
        """The first event for which `happened`."""
        end = time.monotonic() + within_s
        while time.monotonic() < end:
            for event in self.service.log.events_after(after, 1000):
                if happened(event):
                    return event
                after = event.seq
            time.sleep(0.02)
        raise AssertionError(f"not within {within_s} s: {self.service.log.events_after(0, 1000)[-5:]}")

    def events(self, kind: str) -> list[EventView]:
        """All events of a kind so far, oldest first."""
        found: list[EventView] = []
        while page := self.service.log.events_after(found[-1].seq if found else 0, 10_000):
            found += page
        return [event for event in found if event.kind == kind]

    def wait_for_state(self, run: str, state: RunState, after: int = 0) -> EventView:
        """The event that says that a run is in a state."""
        return self.wait_for(lambda e: e.run == run and e.kind == "state" and e.content["state"] == state, after=after)

    def wait_for_ended(self, run: str, within_s: float = 240.0) -> None:
        """Until a run has ended, by its row."""
        end = time.monotonic() + within_s
        while self.store.catalogue.run(run).state not in ENDED:
            assert time.monotonic() < end, self.store.catalogue.run(run)
            time.sleep(0.02)

    def wait_until_idle(self, within_s: float = 240.0) -> None:
        """Until the bench is open and no run is on."""
        end = time.monotonic() + within_s
        while self.controller.state().state != "idle":
            assert time.monotonic() < end, self.controller.state()
            time.sleep(0.02)

    def close(self) -> None:
        """End it all."""
        self._server.should_exit = True
        self._serving.join(10)
        self.controllers.close()
        self.run_log.close()
        self.service.close()
        self.store.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
