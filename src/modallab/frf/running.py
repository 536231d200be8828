"""The FRF of an impact test while it is made: every hit is looked at once, when it comes."""

from typing import Self

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.core.frf import Frf, FrfQuantity
from modallab.core.rig import Rig
from modallab.frf.estimate import hit_sums, lines_of_band, output_quantity
from modallab.frf.sums import Estimator, PowerSums, check_averages
from modallab.signals.block_sets import check_outputs
from modallab.signals.signals import Signals


class RunningFrf:
    """Sums of one impact test by point, and which blocks are in them.

    The same FRF as `impact_frf` of all its blocks (H1), to rounding.
    """

    def __init__(self, rig: Rig, first: Signals, band_hz: tuple[float, float]) -> None:
        """For blocks as long as the first, which is not added yet.

        Raises:
            DataError: other outputs than the rig's, a band without lines.
        """
        check_outputs(first, rig)
        self._rig = rig
        self._shape = first.force.size, first.rate_hz
        self._lines: NDArray[np.int64] = lines_of_band(*self._shape, band_hz)
        self._quantity: FrfQuantity = output_quantity(rig)
        self._sums: dict[int | None, PowerSums] = {}

    @property
    def points(self) -> tuple[int | None, ...]:
        """The points struck so far, in the order in which they came."""
        return tuple(self._sums)

    def add_hit(self, hit: Signals) -> Self:
        """Add a hit.

        Raises:
            DataError: a block without a hit, or of another length or rate.
        """
        if (hit.force.size, hit.rate_hz) != self._shape:
            raise DataError(
                f"{hit.force.size} samples at {hit.rate_hz:g} Hz; "
                f"the blocks before have {self._shape[0]} at {self._shape[1]:g} Hz",
                where=f"record {hit.block.name}",
                remedy="give the blocks of one run",
            )
        point = hit.block.drive_point
        own = hit_sums(hit, self._lines)
        self._sums[point] = self._sums[point].with_more(own) if point in self._sums else own
        return self

    def remove_point(self, point: int | None) -> None:
        """Take all hits of a point out, to add those that still count again."""
        self._sums.pop(point, None)

    def frf(self, points: tuple[int | None, ...] | None = None, estimator: Estimator = "H1") -> Frf:
        """FRFs (outputs, points, lines) with coherence; of all points, or of some of them.

        Raises:
            DataError: no hit yet, a point without one, or with one for H2 or Hv.
        """
        chosen = self.points if points is None else points
        missing = [point for point in chosen if point not in self._sums]
        if missing or not chosen:
            raise DataError(f"no hit at point {missing or 'any'} is accepted yet", remedy="wait for the first good hit")
        check_averages(estimator, [self._sums[point].averages for point in chosen], "hits")
        found = [self._sums[point].frf(estimator) for point in chosen]
        size, rate_hz = self._shape
        return Frf(
            frequency_hz=self._lines * rate_hz / size,
            values=np.stack([value for value, _ in found], axis=1),
            quantity=self._quantity,
            outputs=tuple(c.name for c in self._rig.responses),
            output_points=tuple(c.point for c in self._rig.responses),
            input_points=chosen,
            coherence=np.stack([coherence for _, coherence in found], axis=1),
            averages=tuple(self._sums[point].averages for point in chosen),
        )
