"""What the user may say of an identification; nothing needs to be said in the ordinary case."""

from dataclasses import dataclass

import numpy as np

from modallab.core.errors import IdentificationError
from modallab.core.model import Method


@dataclass(frozen=True, slots=True)
class Options:
    """Parameters of an identification.

    Attributes:
        method: the estimator that finds the poles: "plscf", "era", "circle" (circle fit), or "peak" (half-power).
        band_hz: band, or None for the whole band in which the data have content.
        max_order: highest polynomial order (pLSCF) or number of states (ERA), or None for one that suits the data.
        pick_hz: if given, these modes and no others, whatever the automatic selection says.
        drop_hz: modes to leave out, though the automatic selection has them.
        refine: whether the poles only begin a maximum-likelihood search; None for what is usual with the method: pLSCF
            and ERA are refined, the readings of peaks and circles are not.
    """

    method: Method = "plscf"
    band_hz: tuple[float, float] | None = None
    max_order: int | None = None
    pick_hz: tuple[float, ...] = ()
    drop_hz: tuple[float, ...] = ()
    refine: bool | None = None

    def __post_init__(self) -> None:
        """Reject what no identification can be asked for.

        Raises:
            IdentificationError: a band, an order, or frequencies to pick or drop that cannot be.
        """
        band = self.band_hz
        if band is not None and not (np.isfinite(band).all() and 0 <= band[0] < band[1]):
            raise IdentificationError(
                f"there is no band {band[0]:g} to {band[1]:g} Hz", remedy="give the lower edge first, both in Hz"
            )
        if self.max_order is not None and self.max_order < 1:
            raise IdentificationError(f"order {self.max_order} holds no mode", remedy="ask for an order of at least 2")
        for frequency in (*self.pick_hz, *self.drop_hz):
            if not (np.isfinite(frequency) and frequency > 0):
                raise IdentificationError(f"no mode stands at {frequency:g} Hz", remedy="give a frequency above 0 Hz")

    @property
    def refined(self) -> bool:
        """Whether the result is that of maximum likelihood."""
        return self.method in ("plscf", "era") if self.refine is None else self.refine

    @property
    def as_in_the_paper(self) -> bool:
        """Whether the peaks of the mobility alone make the model, its shapes included."""
        return self.method == "peak" and not self.refined
