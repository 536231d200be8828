"""Force and response of one sine block (figure 4 of the paper)."""

from matplotlib.figure import Figure

from modallab.core.rig import Rig
from modallab.reporting.figures import style
from modallab.reporting.figures.quarters import quarters
from modallab.signals.signals import Signals


def sine_block(signals: Signals, output: int, rig: Rig, to_hz: float = 220.0) -> Figure:
    """Force and response in time and as spectrum, the drive frequency marked.

    Args:
        signals: the block, in SI units; the paper shows the one at 27.34 Hz.
        output: place of the response in `signals.outputs`.
        rig: for the response's quantity and point.
        to_hz: upper end of the spectra.
    """
    figure, axes = quarters(signals, output, rig, to_hz)
    frequency = signals.block.frequency_hz
    if frequency is not None:
        with style.look():
            for spectrum in (axes[1], axes[3]):
                spectrum.axvline(frequency, color=style.SOFT, linewidth=0.9, linestyle=":", zorder=0)
    return figure
