"""What the user may say of an identification; nothing needs to be said in the ordinary case."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.units import FRF_ESTIMATORS, FrfEstimator, Test
from modallab.identification.estimator import USUAL, Estimator, find_estimator

ResponseMethod = Literal["ssi_cov", "plscf_spectra"]
"""How modes of the responses alone are found."""
USUAL_RESPONSE: ResponseMethod = "ssi_cov"


@dataclass(frozen=True, slots=True)
class IdentificationOptions:
    """Parameters of an identification.

    Attributes:
        method: name of the estimator that finds the poles; `estimator_names()` lists them.
        band_hz: band, or None for the whole band in which the data have content.
        max_order: highest order of an estimator that has one, or None for one that suits the data.
        pick_hz: if given, these modes and no others, whatever the automatic selection says.
        drop_hz: modes to leave out, though the automatic selection has them.
        frf: how FRFs are made of records. With H2 and Hv hits are identified from their FRFs; the likelihood of their
            records, which H1 stands for, allows for noise on the force by itself.
        refine: whether the poles only begin a maximum-likelihood search; None for what is usual with the method.
    """

    method: str = USUAL
    band_hz: tuple[float, float] | None = None
    max_order: int | None = None
    pick_hz: tuple[float, ...] = ()
    drop_hz: tuple[float, ...] = ()
    refine: bool | None = None
    frf: FrfEstimator = "H1"

    def __post_init__(self) -> None:
        """Reject what no identification can be asked for.

        Raises:
            IdentificationError: a method, FRF, band, order, or frequencies to pick or drop that cannot be.
        """
        band = self.band_hz
        if band is not None and not (np.isfinite(band).all() and 0 <= band[0] < band[1]):
            raise IdentificationError(
                f"there is no band {band[0]:g} to {band[1]:g} Hz", remedy="give the lower edge first, both in Hz"
            )
        if self.frf not in FRF_ESTIMATORS:
            raise IdentificationError(
                f"no FRF is called {self.frf!r}", remedy=f"use one of {', '.join(FRF_ESTIMATORS)}"
            )
        if self.max_order is not None and self.estimator.order is not None:
            self.estimator.order.check(self.max_order)
        if not (self.refined or self.estimator.damping):
            raise IdentificationError(
                f"{self.estimator.called} reads no damping", remedy="have its poles refined, or use another method"
            )
        for frequency in (*self.pick_hz, *self.drop_hz):
            if not (np.isfinite(frequency) and frequency > 0):
                raise IdentificationError(f"no mode stands at {frequency:g} Hz", remedy="give a frequency above 0 Hz")

    @property
    def estimator(self) -> Estimator:
        """The estimator that `method` names."""
        return find_estimator(self.method)

    @property
    def refined(self) -> bool:
        """Whether the result is that of maximum likelihood."""
        return self.estimator.refined if self.refine is None else self.refine

    @property
    def own_model(self) -> Callable[[Frf, Test | None], ModalModel] | None:
        """The estimator's own modal model, if it makes one and nothing is refined."""
        return None if self.refined else self.estimator.model
