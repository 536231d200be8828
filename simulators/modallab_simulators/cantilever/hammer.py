"""The hammer's hit: one smooth contact, or two."""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Real


@dataclass(frozen=True, slots=True)
class Contact:
    """A contact pulse peak_n sin^2(pi t / width_s) from `start_s`."""

    start_s: float
    width_s: float
    peak_n: float

    def force(self, times_s: Real) -> Real:
        """Force in N at the given times."""
        share = (times_s - self.start_s) / self.width_s
        return np.where((share > 0) & (share < 1), self.peak_n * np.sin(np.pi * share) ** 2, 0.0)


@dataclass(frozen=True, slots=True)
class Hit:
    """What the hammer does at one place; or, where its transducer does not feel it, something else that knocks."""

    x_m: float
    contacts: tuple[Contact, ...]
    seen: bool = True

    @property
    def start_s(self) -> float:
        """When the hammer first touches."""
        return self.contacts[0].start_s

    @property
    def end_s(self) -> float:
        """When it last lets go."""
        return self.contacts[-1].start_s + self.contacts[-1].width_s

    def after(self, wait_s: float) -> "Hit":
        """The same, later."""
        return replace(self, contacts=tuple(replace(c, start_s=c.start_s + wait_s) for c in self.contacts))

    def knock(self, share: float) -> "Hit":
        """A share of the first contact, which the transducer does not feel."""
        first = self.contacts[0]
        return Hit(self.x_m, (replace(first, peak_n=first.peak_n * share),), seen=False)

    def force(self, times_s: Real) -> Real:
        """Force in N at the given times."""
        return np.sum([contact.force(times_s) for contact in self.contacts], axis=0)
