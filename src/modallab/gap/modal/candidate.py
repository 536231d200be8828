"""One kind of change at one place, with what is believed of its numbers."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.modal.compared import Compared
from modallab.gap.modal.free import Change
from modallab.modification.freedoms import Freedom


@dataclass(frozen=True, eq=False, slots=True)
class Candidate:
    """A kind of change at a place.

    Attributes:
        effect: its name in the catalogue.
        freedoms: it acts on; none where it is a channel's.
        channel: output number; None for the force and the structure.
        make: numbers and the lines that are compared -> the change.
        starts: numbers to begin with.
        prior: (numbers,) deviation of each about its start's, infinite where nothing is believed.
        centre: (numbers,) about which.
        width: of the range within which a number without a deviation is believed to lie, one after the other.
        places: so many candidates of this kind there are.
    """

    effect: str
    freedoms: tuple[Freedom, ...]
    channel: int | None
    make: Callable[[Real, Compared], Change] = field(repr=False)
    starts: tuple[Real, ...]
    prior: Real
    centre: Real
    width: tuple[float, ...]
    places: int = 1

    def offset(self, v: Real) -> Real:
        """(2,) m along the tangents from its point, of what hangs on the structure."""
        return v[1:3] if v.size > 2 else np.zeros(2)

    def pull(self, v: Real) -> tuple[Real, Real]:
        """(numbers,) inverse variance of what is believed of each, and half the slope of its squares at v.

        A number that is open within a width is as unknown as one of that width, at most, and drawn nowhere: what moves
        nothing has then the evidence of nothing.
        """
        known = np.isfinite(self.prior)
        weight = np.zeros(self.prior.size)
        weight[known] = 1 / self.prior[known] ** 2
        weight[~known] = 2 * np.pi / np.square(self.width)
        return weight, np.where(known, weight * (v - self.centre), 0.0)

    @property
    def room(self) -> float:
        """-2 ln of the prior density of its numbers, as it adds to -2 ln of the evidence (Laplace)."""
        known = self.prior[np.isfinite(self.prior)]
        spread = np.sum(np.log(known)) + np.sum(np.log(self.width)) - len(self.width) * np.log(2 * np.pi) / 2
        return float(2 * (spread + np.log(self.places)))
