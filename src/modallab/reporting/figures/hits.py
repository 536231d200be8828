"""Every hit of the hammer, counted or rejected."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from modallab.reporting.content import ReportedHit
from modallab.reporting.figures import style
from modallab.reporting.figures.overview import spread_colours, zero_as_gap

BEFORE_S, AFTER_S = 0.005, 0.04


def hits_figure(hits: Sequence[ReportedHit], band_hz: tuple[float, float]) -> Figure:
    """The force pulses, laid over one another at their peaks, and their spectra.

    Args:
        hits: all hits, the rejected ones are drawn dashed.
        band_hz: band of the test, shaded in the spectra: there a hit must have force.
    """
    points = sorted({h.point for h in hits if h.accepted}, key=lambda p: -1 if p is None else p)
    colours = dict(zip(points, spread_colours(len(points)) if points else [], strict=True))
    with style.figure_style():
        figure, (pulse, spectrum) = style.panel_grid(2, 2)
        for hit in hits:
            options = _line_options(hit, colours)
            time, force = cut_pulse(hit)
            pulse.plot(time * 1e3, force, **options)
            frequency, height = impulse_spectrum(hit)
            spectrum.plot(frequency[1:], zero_as_gap(height)[1:], **options)
        style.label_axes(pulse, "Force pulses", "time from the peak [ms]", "force [N]")
        top = max(impulse_spectrum(h)[1][1:].max() for h in hits)
        style.make_logarithmic(spectrum)
        spectrum.set_ylim(top / 3e3, top * 2)
        spectrum.axvspan(*band_hz, color=style.SHADE, zorder=0, linewidth=0)
        spectrum.set_xlim(0, min(6 * band_hz[1], hits[0].rate_hz / 2))
        style.label_axes(spectrum, "Spectra, band of the test shaded", "frequency [Hz]", "impulse density [N·s]")
        style.figure_legend(figure, _legend_key(hits, colours))
    return figure


def cut_pulse(hit: ReportedHit) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Time from the peak in s and force in N, from just before to just after the contact."""
    peak = int(np.argmax(np.abs(hit.force_n)))
    first = max(peak - round(BEFORE_S * hit.rate_hz), 0)
    last = min(peak + round(AFTER_S * hit.rate_hz) + 1, hit.force_n.size)
    return (np.arange(first, last) - peak) / hit.rate_hz, hit.force_n[first:last]


def impulse_spectrum(hit: ReportedHit) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Frequencies in Hz and the amplitude of the force's Fourier transform in N s."""
    n = hit.force_n.size
    return np.fft.rfftfreq(n, 1 / hit.rate_hz).astype(np.float64), np.abs(np.fft.rfft(hit.force_n)) / hit.rate_hz


def _line_options(hit: ReportedHit, colours: dict[int | None, str]) -> dict[str, Any]:
    if hit.accepted:
        return {"color": colours[hit.point], "linewidth": 1.3}
    return {"color": style.WARNING, "linewidth": 1.1, "linestyle": "--"}


def _legend_key(hits: Sequence[ReportedHit], colours: dict[int | None, str]) -> list[Line2D]:
    lines = [
        Line2D([], [], color=colour, label="counted" if point is None else f"counted, point {point}")
        for point, colour in colours.items()
    ]
    if any(not h.accepted for h in hits):
        lines.append(Line2D([], [], color=style.WARNING, linestyle="--", label="rejected"))
    return lines
