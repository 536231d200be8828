"""What the user may say of an identification; nothing needs to be said in the ordinary case."""

from dataclasses import dataclass

from modallab.schema.model import Method


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

    @property
    def refined(self) -> bool:
        """Whether the result is that of maximum likelihood."""
        return self.method in ("plscf", "era") if self.refine is None else self.refine

    @property
    def as_in_the_paper(self) -> bool:
        """Whether the peaks of the mobility alone make the model, its shapes included."""
        return self.method == "peak" and not self.refined
