"""Force and response of one hit (figure 5 of the paper)."""

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from modallab.core.rig import Rig
from modallab.reporting.figures import style
from modallab.reporting.figures.quarters import amplitude, quarters
from modallab.signals.signals import Signals


def impact_block(
    signals: Signals, output: int, rig: Rig, filtered: NDArray[np.float64] | None = None, to_hz: float = 220.0
) -> Figure:
    """Force and response in time and as spectrum, the filtered response dashed in the fourth panel.

    Args:
        signals: the block, in SI units.
        output: place of the response in `signals.outputs`.
        rig: for the response's quantity and point.
        filtered: (outputs, n) the responses after the band-pass filter.
        to_hz: upper end of the spectra.
    """
    figure, axes = quarters(signals, output, rig, to_hz)
    if filtered is None:
        return figure
    with style.look():
        axes[3].lines[0].set_label("as measured")
        frequency, height = amplitude(filtered[output], signals.rate_hz)
        # Far outside the band the filter leaves next to nothing; the axis stays with what was measured.
        low, high = axes[3].get_ylim()
        axes[3].plot(
            frequency[1:], height[1:], "--", color=style.INK, linewidth=1.3, label="after the band-pass filter"
        )
        axes[3].set_ylim(low / 3, high)
        style.legend(figure, axes[3].lines)
    return figure
