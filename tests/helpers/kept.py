"""Who follows a run, what was acknowledged to him, and whether it is still there."""

import zlib
from contextlib import suppress
from threading import Thread

from modallab.client import Client
from modallab.client.connection import ServiceProblemError
from modallab.core.documents.pages import EventView


class Follower:
    """Follows all events of a service from a thread, through its restarts."""

    def __init__(self, url: str, token: str) -> None:
        self.url, self.token = url, token
        self.events: list[EventView] = []
        self._thread = Thread(target=self._follow, daemon=True)
        self._thread.start()

    @property
    def acknowledged(self) -> dict[tuple[str, int], int]:
        """CRC-32 of every block that was acknowledged, by run and number."""
        return {(e.run, e.content["n"]): e.content["crc32"] for e in list(self.events) if e.kind == "block"}

    def _follow(self) -> None:
        # Once its service has ended, another may answer at its address, and know nothing of its token.
        with Client(self.url, self.token) as client, suppress(ServiceProblemError):
            for event in client.follow_events():
                self.events.append(event)


def require_kept(client: Client, acknowledged: dict[tuple[str, int], int]) -> None:
    """Every acknowledged block is there, and its samples have the CRC that was acknowledged."""
    for run in {run for run, _ in acknowledged}:
        listed = {block.n: block.crc32 for block in client.blocks(run)}
        for (of, n), crc in acknowledged.items():
            if of == run:
                assert listed[n] == crc
                assert zlib.crc32(client.samples(run, n).tobytes()) == crc
