"""What still rang when a hit came."""

from dataclasses import dataclass

from modallab.acquisition.monitor.context import Context
from modallab.acquisition.monitor.settled import Floor, residual_ratio


@dataclass(frozen=True, slots=True)
class Ringing:
    """The motion before a hit.

    Attributes:
        residual_ratio: its amplitude as part of the hit's own, where that is largest; 0 if it does not show.
        residual_hz: where that is.
    """

    residual_ratio: float
    residual_hz: float

    def rejections(self, allowed: float) -> list[str]:
        """Why the hit does not count, if more than the part `allowed` of it rang before."""
        if self.residual_ratio <= allowed:
            return []
        return [
            f"not at rest before: {100 * self.residual_ratio:.3g} % of this hit at {self.residual_hz:.4g} Hz,"
            f" at most {100 * allowed:g} %"
        ]


def ringing_before(context: Context, first: int, floor: Floor) -> Ringing:
    """The window before the block from sample `first`, beside the block."""
    before = context.motion(first - context.window, context.window)
    ratio, line = residual_ratio(before, context.motion(first, context.block), floor)
    return Ringing(ratio, line * context.line_hz)
