"""What the user may say of an identification; nothing needs to be said in the ordinary case."""

from dataclasses import dataclass

from modallab.schema.model import Method


@dataclass(frozen=True, slots=True)
class Options:
    """Parameters of an identification.

    Attributes:
        method: "plscf" (with maximum-likelihood refinement) or "peak" (the paper's).
        band_hz: band, or None for the whole band in which the data have content.
        max_order: highest polynomial order, or None for one that suits the number of inputs.
        pick_hz: if given, these modes and no others, whatever the automatic selection says.
        drop_hz: modes to leave out, though the automatic selection has them.
    """

    method: Method = "plscf"
    band_hz: tuple[float, float] | None = None
    max_order: int | None = None
    pick_hz: tuple[float, ...] = ()
    drop_hz: tuple[float, ...] = ()
