"""Force and response, each in time and as amplitude spectrum: the frame of the paper's figures 4 and 5."""

from math import nan

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from modallab.core.rig import Rig
from modallab.core.units import SI_UNIT
from modallab.reporting.figures import style
from modallab.reporting.figures.selection import place
from modallab.signals.signals import Signals


def quarters(signals: Signals, output: int, rig: Rig, to_hz: float) -> tuple[Figure, list[Axes]]:
    """Four panels: force and response in time, below each other; beside each its spectrum.

    Args:
        signals: one block in SI units.
        output: place of the response in `signals.outputs`.
        rig: for the response's quantity and point.
        to_hz: upper end of the spectra.
    """
    name = signals.outputs[output]
    channel = next((c for c in rig.channels if c.name == name), None)
    quantity = channel.quantity if channel else "acceleration"
    where = place(name, channel.point if channel else None)
    with style.look():
        figure, axes = style.grid(4, 2)
        # Of several forces the first one's is shown, and said to be.
        force = "Force" if len(signals.forces) == 1 else f"Force at point {signals.block.drive_point}"
        _pair(axes[:2], force, "N", signals.forces[0], signals.rate_hz, to_hz, style.MODEL)
        _pair(
            axes[2:],
            f"{where}, {quantity}",
            SI_UNIT[quantity].replace("^2", "²"),
            signals.responses[output],
            signals.rate_hz,
            to_hz,
            style.MEASURED,
        )
    return figure, axes


def amplitude(samples: NDArray[np.float64], rate_hz: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Frequencies in Hz and the amplitude of the sine at each line, in the unit of the samples; no window."""
    n = samples.shape[-1]
    return np.fft.rfftfreq(n, 1 / rate_hz).astype(np.float64), np.abs(np.fft.rfft(samples)) * 2 / n


def _pair(
    axes: list[Axes], what: str, unit: str, samples: NDArray[np.float64], rate_hz: float, to_hz: float, colour: str
) -> None:
    time, spectrum = axes
    quantity = what.rsplit(", ", 1)[-1].lower()
    time.plot(np.arange(samples.size) / rate_hz, samples, color=colour, linewidth=1.1)
    style.label(time, what, "time [s]", f"{quantity} [{unit}]")
    time.set_xlim(0, samples.size / rate_hz)
    frequency, height = amplitude(samples, rate_hz)
    # Line 0 is the mean, which has no place on a logarithmic axis of vibrations.
    height = np.where(height > 0, height, nan)
    spectrum.plot(frequency[1:], height[1:], color=colour, linewidth=1.1)
    style.logarithmic(spectrum)
    style.label(spectrum, f"{what}, spectrum", "frequency [Hz]", f"amplitude [{unit}]")
    spectrum.set_xlim(0, min(to_hz, rate_hz / 2))
