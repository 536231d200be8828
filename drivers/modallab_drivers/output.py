"""What drives the shaker, as a bench sees it: an analog output or a generator."""

from typing import Protocol

from modallab.bench.protocol import Burst


class Output(Protocol):
    """An excitation output. All times are counts of the bench's own samples."""

    @property
    def range_v(self) -> float:
        """The largest amplitude it can give."""
        ...

    @property
    def busy(self) -> bool:
        """Whether a burst is on."""
        ...

    def play(self, burst: Burst, now: int, rate_hz: float) -> None:
        """Start a burst now, at sample `now` of a bench at `rate_hz`."""
        ...

    def next_event(self) -> int | None:
        """The sample at which it must be looked after next, if there is one."""
        ...

    def tick(self, now: int) -> None:
        """Look after the burst that is on.

        Raises:
            OutputLostError: the device could not keep it going.
        """
        ...

    def zero(self) -> None:
        """Bring it to 0 V now."""
        ...

    def close(self) -> None:
        """Bring it to 0 V and let go of it."""
        ...
