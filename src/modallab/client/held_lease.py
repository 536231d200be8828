"""A lease that is renewed while it is held."""

from collections.abc import Callable
from threading import Event as Flag
from threading import Thread
from typing import Self

import httpx

from modallab.core.documents.rigs import Lease


class HeldLease:
    """The lease of a rig, as a context manager: renewed in the background, given back at the end."""

    def __init__(self, lease: Lease, renew: Callable[[Lease], object], release: Callable[[Lease], object]) -> None:
        self.lease = lease
        self._renew = renew
        self._release = release
        self._closing = Flag()
        self.lost: Exception | None = None
        self._thread = Thread(target=self._hold, name=f"lease of {lease.rig}", daemon=True)
        self._thread.start()

    @property
    def id(self) -> str:
        """What the service wants to see with every command."""
        return self.lease.id

    def close(self) -> None:
        """Give it back; a lease that is lost is not given back."""
        self._closing.set()
        self._thread.join()
        if self.lost is None:
            self._release(self.lease)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _hold(self) -> None:
        while not self._closing.wait(self.lease.ttl_s / 4):
            try:
                self._renew(self.lease)
            except httpx.HTTPError:
                # No answer is no rejection: a busy service may give one yet, before the lease is over.
                continue
            except Exception as error:
                # The next command says so too; a thread has nobody to report it to.
                self.lost = error
                return
