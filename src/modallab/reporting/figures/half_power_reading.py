"""What the half-power rule reads off one block, for any damping the beam may have."""

from math import nan, pi

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from modallab.core.digits import short_number
from modallab.identification.start.half_power import half_power_near
from modallab.reporting.compare import ComparedMode, ModeReading
from modallab.reporting.figures import style
from modallab.reporting.figures.damping import paper_value

LIGHTEST, HEAVIEST = 5e-4, 0.3
_SAMPLES_A_PERIOD = 16


def half_power_reading(
    mode: ComparedMode, reading: ModeReading, block_s: float, before_s: float, paper: bool = True
) -> Figure:
    """The half-power reading against the damping the beam has; a flat curve is a rule that does not see the beam.

    Args:
        mode: the mode whose block is played.
        reading: what the rule read for it.
        block_s: length of the block.
        before_s: time in the block before the hit.
        paper: whether this is the paper's bench, so that its value belongs here.
    """
    floor = reading.half_power_floor
    zeta = np.geomspace(min(LIGHTEST, floor / 10) if floor > 0 else LIGHTEST, HEAVIEST, 60)
    with style.figure_style():
        figure, (axes,) = style.panel_grid(1, 1, style.PanelSize(420, 290))
        axes.plot(100 * zeta, 100 * zeta, color=style.SOFT, linewidth=1.0, label="a rule that reads the beam")
        for hann, line, name in ((False, "-", "half-power, no window"), (True, "--", "half-power, Hann window")):
            read = half_power_readings(mode.frequency_hz, zeta, block_s, before_s, hann)
            axes.plot(100 * zeta, 100 * read, line, color=style.WARNING, linewidth=2.2, label=name)
        _draw_marks(axes, mode, reading, paper)
        axes.set_xlim(100 * zeta[0], 100 * zeta[-1])
        style.make_logarithmic(axes, "x")
        style.make_logarithmic(axes)
        title = f"Mode {mode.number} in a block of {short_number(block_s)} s"
        style.label_axes(axes, title, "damping ratio of the beam [%]", "half-power reading ζ [%]")
        style.figure_legend(figure, [line for line in axes.lines if not str(line.get_label()).startswith("_")])
    return figure


def half_power_readings(
    frequency_hz: float, zeta: NDArray[np.float64], block_s: float, before_s: float, hann: bool
) -> NDArray[np.float64]:
    """(n,) damping ratios that half-power reads of modes with each zeta (n,), in a block shorter than the ring-down.

    The velocity after an ideal hit at `before_s`, sampled closely, is transformed as the paper does it.
    """
    n = int(np.ceil(block_s * frequency_hz * _SAMPLES_A_PERIOD))
    t = np.arange(n) / n * block_s - before_s
    omega = 2 * pi * frequency_hz
    damped = omega * np.sqrt(1 - zeta[:, None] ** 2)
    decay = np.exp(-zeta[:, None] * omega * np.maximum(t, 0.0))
    velocity = np.where(t >= 0, decay * (np.cos(damped * t) - zeta[:, None] * omega / damped * np.sin(damped * t)), 0.0)
    if hann:
        velocity = velocity * np.sin(pi * np.arange(n) / n) ** 2
    lines = np.fft.rfftfreq(n, block_s / n).astype(np.float64)
    return np.array([half_power_near(lines, a, frequency_hz) for a in np.abs(np.fft.rfft(velocity))])


def _draw_marks(axes: Axes, mode: ComparedMode, reading: ModeReading, papers: bool) -> None:
    axes.plot(
        [100 * mode.best.damping],
        [100 * reading.half_power if reading.half_power > 0 else nan],
        "D",
        color=style.INK,
        markersize=8,
        zorder=5,
        label="read in this test",
    )
    paper = paper_value(mode) if papers else None
    if paper is None:
        return
    for value in (paper, paper / 2):
        axes.axhline(100 * value, color=style.THIRD, linewidth=1.4, linestyle=":")
    axes.lines[-1].set_label(f"the paper's {100 * paper:.1f} %, read both ways")
