"""Damping as identified, beside what the half-power rule can see in a block of this length."""

from collections.abc import Sequence
from math import isclose, isfinite, nan, pi
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from modallab.core.digits import short_number, significant_digits
from modallab.core.rig import Rig
from modallab.identification.selection.criteria import SAME_MODE
from modallab.identification.start.half_power import half_power_near
from modallab.reporting.compare import ComparedMode, ModeReading
from modallab.reporting.figures import style

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
        axes.plot(
            100 * zeta, 100 * zeta, color=style.SOFT, linewidth=1.0, label="a rule that reads the damping of the beam"
        )
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


PAPER = ((4.8, 0.1250), (30.9, 0.0385), (87.8, 0.0103))
"""Table 1 of the paper: frequency in Hz and what it calls modal damping, as ratios."""
LINK_M = (0.05, 0.004)
"""Width and thickness of the paper's elastic link."""
MANY = 6
"""More modes than this stand closer together."""
_PAPER: dict[str, Any] = {
    "color": style.THIRD,
    "markerfacecolor": style.PAPER,
    "markersize": 6.5,
    "linestyle": "none",
    "zorder": 4,
}
_MARKS = {"impact": "o", "sine": "s", None: "o"}


def damping_figure(modes: Sequence[ComparedMode], paper: bool = True) -> Figure:
    """One row a mode on a logarithmic scale of damping, one bar a test.

    The grey bar reaches up to the floor of the half-power rule: what it reads for a mode inside lies at the bar's end,
    whatever the beam does.

    Args:
        modes: matched over the tests, with the truth where it is known.
        paper: whether this is the paper's bench, so that its values belong beside these.
    """
    height = 62 if len(modes) <= MANY else 42
    with style.figure_style():
        figure, (axes,) = style.panel_grid(1, 1, style.PanelSize(420, 104 + height * max(len(modes), 1)))
        values: list[float] = []
        for row, mode in enumerate(modes):
            values += _draw_mode(axes, -row, mode, paper)
        _set_scale(axes, values)
        axes.set_yticks(
            range(0, -len(modes), -1), [f"mode {m.number}\n{significant_digits(m.frequency_hz, 3)} Hz" for m in modes]
        )
        axes.set_ylim(-len(modes) + 0.4, 0.6)
        axes.grid(axis="y", visible=False)
        style.label_axes(axes, "Damping ratio of each mode", "damping ratio ζ [%]", "")
        style.figure_legend(figure, _legend_key(modes, paper))
    return figure


def paper_value(mode: ComparedMode) -> float | None:
    """What the paper's Table 1 gives for this mode, if it is one of its three by frequency."""
    return next((value for f, value in PAPER if abs(mode.frequency_hz - f) <= SAME_MODE * f), None)


def is_bench_of_paper(rig: Rig) -> bool:
    """Whether it is the paper's bench: a cantilever with the cross-section of its elastic link."""
    if rig.model != "cantilever" or rig.beam is None:
        return False
    section = (rig.beam.width_m, rig.beam.thickness_m)
    return all(isclose(ours, theirs, rel_tol=0.05) for ours, theirs in zip(section, LINK_M, strict=True))


def _draw_mode(axes: Axes, y: float, mode: ComparedMode, papers: bool) -> list[float]:
    values: list[float] = []
    n = len(mode.readings)
    for place, reading in enumerate(mode.readings):
        height = 0.56 / n
        centre = y + 0.28 - height * (place + 0.5)
        values += _draw_test(axes, centre, height * (0.9 if n > 1 else 1.0), reading)
        values += _draw_identified(axes, centre, reading.damping, reading.damping_sigma, _MARKS[reading.test])
    paper = paper_value(mode) if papers else None
    if paper is not None:
        values += [50 * paper, 100 * paper]
        axes.plot([50 * paper, 100 * paper], [y - 0.4] * 2, "^", **_PAPER)
    if isfinite(mode.true_damping):
        values.append(100 * mode.true_damping)
        axes.vlines(100 * mode.true_damping, y - 0.36, y + 0.36, color=style.SECOND, linewidth=2.2, zorder=3)
    return values


def _draw_test(axes: Axes, y: float, height: float, reading: ModeReading) -> list[float]:
    values: list[float] = []
    floor = 100 * reading.half_power_floor
    if isfinite(floor) and floor > 0:
        values.append(floor)
        axes.barh(y, floor, height=height, left=1e-9, color=style.SHADE, zorder=1)
        axes.vlines(floor, y - height / 2, y + height / 2, color=style.SOFT, linewidth=2, zorder=2)
    if isfinite(reading.half_power) and reading.half_power > 0:
        values.append(100 * reading.half_power)
        axes.plot(100 * reading.half_power, y, "D", color=style.WARNING, markersize=6.5, zorder=4)
    return values


def _draw_identified(axes: Axes, y: float, zeta: float, sigma: float, marker: str) -> list[float]:
    if not (isfinite(zeta) and zeta > 0):
        return []
    error = [[100 * min(sigma, 0.9 * zeta)], [100 * sigma]] if isfinite(sigma) else None
    hollow = marker != "o"
    axes.errorbar(
        100 * zeta,
        y,
        xerr=error,
        fmt=marker,
        color=style.MEASURED,
        markerfacecolor=style.PAPER if hollow else style.MEASURED,
        markersize=7,
        capsize=4,
        zorder=5,
    )
    return [100 * zeta]


def _set_scale(axes: Axes, values: list[float]) -> None:
    known = [v for v in values if v > 0] or [0.1, 10.0]
    axes.set_xlim(min(known) / 2, max(known) * 2)
    style.make_logarithmic(axes, "x")


def _legend_key(modes: Sequence[ComparedMode], paper: bool) -> list[Line2D | Patch]:
    tests = list(dict.fromkeys(r.test for m in modes for r in m.readings))
    handles: list[Line2D | Patch] = [
        Line2D(
            [],
            [],
            linestyle="none",
            marker=_MARKS[test],
            color=style.MEASURED,
            markerfacecolor=style.PAPER if _MARKS[test] != "o" else style.MEASURED,
            label=f"identified, {test or 'FRFs'} ± σ",
        )
        for test in tests
    ]
    handles.append(Line2D([], [], linestyle="none", marker="D", color=style.WARNING, label="half-power reading"))
    handles.append(Patch(facecolor=style.SHADE, label="below the resolution"))
    if paper and any(paper_value(m) is not None for m in modes):
        handles.append(Line2D([], [], marker="^", label="the paper's Table 1, both readings", **_PAPER))
    if any(isfinite(m.true_damping) for m in modes):
        handles.append(Line2D([], [], color=style.SECOND, linewidth=2.2, label="truth"))
    return handles
