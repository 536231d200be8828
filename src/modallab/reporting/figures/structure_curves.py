"""FRFs of a structure where it misses its model most: measured, of the reference, and of the reference corrected."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from modallab.core.arrays import Complex, Real
from modallab.core.frf import Frf
from modallab.gap.modal.diagnosis import ComparisonOutcome
from modallab.gap.modal.free import Free
from modallab.modification.frfs import outside_band_receptances, receptances_of_model
from modallab.reporting.figures import style
from modallab.reporting.figures.mobility import hide_zeros

MOST, LINES = 4, 600
"""Panels, and lines of a curve besides those about the modes."""
ABOUT = np.linspace(-4.0, 4.0, 25)
"""Lines about a mode, in half widths of its resonance."""
RECORDS, MEASURED, BEFORE, LEFT = "records", "identified from them", "reference", "what is left"
WITH, WITHIN = "reference with the effects found", "reference within the tolerances"
BELOW = 100.0
"""The axis ends at most so many times below the lowest curve, however small what is left."""


@dataclass(frozen=True, eq=False, slots=True)
class _Curves:
    """(lines, outputs, inputs) mobilities at hz."""

    hz: Real
    measured: Complex
    before: Complex
    after: Complex
    after_said: str


def structure_curves(explained: ComparisonOutcome, records: Frf | None) -> Figure:
    """Mobility of the outputs that miss most, each at the driven point where it does.

    Args:
        explained: the comparison.
        records: mobility of the records themselves, drawn below; None where there is none.
    """
    curves, pairs = _mobility_curves(explained), worst_outputs(explained)
    with style.figure_style():
        figure, panels = style.panel_grid(len(pairs), min(2, len(pairs)))
        for (o, i), axes in zip(pairs, panels, strict=True):
            name, point = explained.free.of.model.outputs[o], explained.free.of.model.input_points[i]
            _draw_panel(axes, curves, _row_of_output(records, name, point), o, i)
            style.label_axes(axes, f"{name}, force at point {point}", "frequency [Hz]", "mobility [m/(N·s)]")
        lines = {str(line.get_label()): line for axes in panels for line in axes.lines}
        style.figure_legend(figure, list(lines.values()))
    return figure


def worst_outputs(explained: ComparisonOutcome) -> list[tuple[int, int]]:
    """(output, input) of the outputs with the widest gap within the tolerances, the widest first."""
    free, base = explained.free, explained.judged.base
    square = np.mean(free.missed(base.u, base.change) ** 2, axis=0)
    order = np.argsort(-np.mean(square, axis=1), kind="stable")[:MOST]
    return [(int(o), int(np.argmax(square[o]))) for o in order]


def _mobility_curves(explained: ComparisonOutcome) -> _Curves:
    free, c = explained.free, explained.free.of
    hz = _frequencies(free)
    s = np.asarray(2j * np.pi * hz)
    part = partial(outside_band_receptances, c.model)
    best = explained.judged.best
    changed = best.candidate is not None
    before = free.at(s, part).predicted(np.zeros(free.size))
    after = best.free.at(s, part).predicted(best.u, best.change.between_lines)
    rate = s[:, None, None]
    which = WITH if changed else WITHIN
    return _Curves(hz, rate * receptances_of_model(c.bench, s), rate * before, rate * after, which)


def _frequencies(free: Free) -> Real:
    """(lines,) Hz over the band of the comparison, close about the modes of both."""
    low, high = free.of.s.imag[[0, -1]] / (2 * np.pi)
    models = (free.of.model, free.of.bench)
    near = [(m.frequency_hz * (1 + m.damping_ratio * a)) for m in models for a in ABOUT]
    hz = np.unique(np.concatenate([np.geomspace(low, high, LINES), *near]))
    return hz[(hz >= low) & (hz <= high)]


def _row_of_output(records: Frf | None, output: str, point: int | None) -> tuple[Real, Real] | None:
    if records is None or output not in records.outputs or point not in records.input_points:
        return None
    values = records.values[records.outputs.index(output), records.input_points.index(point)]
    return records.frequency_hz, np.abs(values)


def _draw_panel(axes: Axes, curves: _Curves, records: tuple[Real, Real] | None, o: int, i: int) -> None:
    measured, before, after = (np.abs(v[:, o, i]) for v in (curves.measured, curves.before, curves.after))
    if records is not None:
        axes.plot(records[0], hide_zeros(records[1]), label=RECORDS, color=style.SOFT, linewidth=0.7, alpha=0.6)
    axes.plot(curves.hz, measured, label=MEASURED, color=style.MEASURED, linewidth=3.6, alpha=0.5)
    axes.plot(curves.hz, before, label=BEFORE, color=style.INK, linewidth=1.0, linestyle=":")
    axes.plot(curves.hz, after, label=curves.after_said, color=style.MODEL, linewidth=1.5, linestyle="--")
    left = np.abs(curves.measured[:, o, i] - curves.after[:, o, i])
    axes.plot(curves.hz, left, label=LEFT, color=style.WARNING, linewidth=0.9)
    style.make_logarithmic(axes)
    axes.set_xlim(curves.hz[0], curves.hz[-1])
    shown = [*measured, *before, *after]
    axes.set_ylim(max(min(shown) / BELOW, float(left.min()) / 2), 2 * max(shown))
