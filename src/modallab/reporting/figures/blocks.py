"""Blocks in time and as spectra: force and response (the paper's figures 4 and 5), and every hit of the hammer."""

from collections.abc import Sequence
from math import nan
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from modallab.core.rig import Rig
from modallab.core.units import SI_UNIT
from modallab.reporting.content import ReportedHit
from modallab.reporting.figures import style
from modallab.reporting.figures.mobility import hide_zeros, spread_colours
from modallab.reporting.figures.mode_shapes import sensor_label
from modallab.signals.signals import Signals

BEFORE_S, AFTER_S = 0.005, 0.04


def block_panels(signals: Signals, output: int, rig: Rig, to_hz: float) -> tuple[Figure, list[Axes]]:
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
    where = sensor_label(name, channel.point if channel else None)
    with style.figure_style():
        figure, axes = style.panel_grid(4, 2)
        # Of several forces the first one's is shown, and said to be.
        force = "Force" if len(signals.forces) == 1 else f"Force at point {signals.block.drive_point}"
        _time_and_spectrum(axes[:2], force, "N", signals.forces[0], signals.rate_hz, to_hz, style.MODEL)
        _time_and_spectrum(
            axes[2:],
            f"{where}, {quantity}",
            SI_UNIT[quantity].replace("^2", "²"),
            signals.responses[output],
            signals.rate_hz,
            to_hz,
            style.MEASURED,
        )
    return figure, axes


def amplitude_spectrum(samples: NDArray[np.float64], rate_hz: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Frequencies in Hz and the amplitude of the sine at each line, in the unit of the samples; no window."""
    n = samples.shape[-1]
    return np.fft.rfftfreq(n, 1 / rate_hz).astype(np.float64), np.abs(np.fft.rfft(samples)) * 2 / n


def _time_and_spectrum(
    axes: list[Axes], what: str, unit: str, samples: NDArray[np.float64], rate_hz: float, to_hz: float, colour: str
) -> None:
    time, spectrum = axes
    quantity = what.rsplit(", ", 1)[-1].lower()
    time.plot(np.arange(samples.size) / rate_hz, samples, color=colour, linewidth=1.1)
    style.label_axes(time, what, "time [s]", f"{quantity} [{unit}]")
    time.set_xlim(0, samples.size / rate_hz)
    frequency, height = amplitude_spectrum(samples, rate_hz)
    # Line 0 is the mean, which has no place on a logarithmic axis of vibrations.
    height = np.where(height > 0, height, nan)
    spectrum.plot(frequency[1:], height[1:], color=colour, linewidth=1.1)
    style.make_logarithmic(spectrum)
    style.label_axes(spectrum, f"{what}, spectrum", "frequency [Hz]", f"amplitude [{unit}]")
    spectrum.set_xlim(0, min(to_hz, rate_hz / 2))


def sine_block(signals: Signals, output: int, rig: Rig, to_hz: float = 220.0) -> Figure:
    """Force and response in time and as spectrum, the drive frequency marked.

    Args:
        signals: the block, in SI units; the paper shows the one at 27.34 Hz.
        output: place of the response in `signals.outputs`.
        rig: for the response's quantity and point.
        to_hz: upper end of the spectra.
    """
    figure, axes = block_panels(signals, output, rig, to_hz)
    frequency = signals.block.frequency_hz
    if frequency is not None:
        with style.figure_style():
            for spectrum in (axes[1], axes[3]):
                spectrum.axvline(frequency, color=style.SOFT, linewidth=0.9, linestyle=":", zorder=0)
    return figure


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
    figure, axes = block_panels(signals, output, rig, to_hz)
    if filtered is None:
        return figure
    with style.figure_style():
        axes[3].lines[0].set_label("as measured")
        frequency, height = amplitude_spectrum(filtered[output], signals.rate_hz)
        # Far outside the band the filter leaves next to nothing; the axis stays with what was measured.
        low, high = axes[3].get_ylim()
        axes[3].plot(
            frequency[1:], height[1:], "--", color=style.INK, linewidth=1.3, label="after the band-pass filter"
        )
        axes[3].set_ylim(low / 3, high)
        style.figure_legend(figure, axes[3].lines)
    return figure


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
            frequency, height = _impulse_spectrum(hit)
            spectrum.plot(frequency[1:], hide_zeros(height)[1:], **options)
        style.label_axes(pulse, "Force pulses", "time from the peak [ms]", "force [N]")
        top = max(_impulse_spectrum(h)[1][1:].max() for h in hits)
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


def _impulse_spectrum(hit: ReportedHit) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
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
