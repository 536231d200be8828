"""One fault of one channel, and how a sentence names it."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault that samples show.

    Attributes:
        channel: its name.
        what: the fault, with its size, as "flat tops at 0.6".
        first_s: when it begins, in s from the first sample.
        samples: how many it spoils.
    """

    channel: str
    what: str
    first_s: float
    samples: int

    def __str__(self) -> str:
        return f"channel {self.channel}: {self.what}, {self.samples} samples from {self.first_s:.6g} s on"
