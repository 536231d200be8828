"""What was measured, what was simulated before and after a diagnosis, and what is left, where it matters most."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from modallab.core.arrays import Complex, Real
from modallab.core.block import Block, Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.rig import Channel
from modallab.core.units import SI_UNIT
from modallab.gap.model.forward import predict_record
from modallab.gap.report.calibrated import diagnosed_twin, twin_of_rig_file
from modallab.reporting.figures import style
from modallab.signals.hit import windowed_force
from modallab.signals.signals import Signals, to_signals
from modallab.twin.bench import Twin

PERIODS = 4
"""Periods of a sine that are shown."""
HIT_S = 0.04
"""Length of a hit's record that is shown."""
BAND = 0.2
"""Share of the rate up to which FRFs are shown."""
BELOW = 300
"""An FRF's axis ends at most so many times below the lowest curve, however small the residual."""
MEASURED, BEFORE, AFTER, LEFT = (
    "measured",
    "simulated from the rig file",
    "with the effects found",
    "what is left",
)


@dataclass(frozen=True, eq=False, slots=True)
class _RecordPair:
    """A record measured and simulated, (channels, n) each."""

    responses: tuple[Channel, ...]
    signals: Signals
    before: Real
    after: Real


def gap_curves(diagnosis: Diagnosis, campaign: Campaign) -> Figure | None:
    """FRFs and records of the channels with the largest gap; None where no record can be simulated.

    Panels: the FRF from the hits that are off most, on the worst channel and at the driving point, or on the channel
    next to worst; one of those hits, and the sine block that is off most, in time, each with its residual beside it.
    """
    twins = twin_of_rig_file(campaign.rig), diagnosed_twin(diagnosis, campaign.rig, of_others=False)
    ranked = _worst_rows(diagnosis.gap.by_channel, [c.name for c in campaign.rig.responses])
    if not ranked:
        return None
    rows = {c.name: row for row, c in enumerate(campaign.rig.responses)}
    worst, row = ranked[0], rows[ranked[0]]
    draws: list[Callable[[Axes], None]] = []
    hits = _draw_hits(diagnosis, campaign)
    if hits:
        seen = [_record_pair(b, campaign, twins) for b in hits]
        for name in dict.fromkeys((worst, *_driving_row(campaign, hits[0]), *ranked[1:2])):
            title = f"{name}, FRF of the hits at point {hits[0].drive_point}"
            draws.append(partial(_draw_frf, seen=seen, row=rows[name], title=title))
        del draws[2:]
        title = f"{worst}, a hit at point {hits[0].drive_point}"
        draws += _record_and_residual(seen[0], row, _about_hit(seen[0]), title)
    sine = _draw_sine(diagnosis, campaign)
    if sine is not None:
        one = _record_pair(sine, campaign, twins)
        level = f", {sine.level}" if sine.level else ""
        title = f"{worst}, sine of {sine.frequency_hz:.4g} Hz{level}"
        draws += _record_and_residual(one, row, _time_of_periods(one), title)
    return _drawn_panels(draws) if draws else None


def _driving_row(campaign: Campaign, hit: Block) -> list[str]:
    return [c.name for c in campaign.rig.responses if c.point == hit.drive_point][:1]


def _record_and_residual(seen: _RecordPair, row: int, shown: slice, title: str) -> list[Callable[[Axes], None]]:
    return [
        partial(_draw_record, seen=seen, row=row, shown=shown, title=title),
        partial(_draw_residual, seen=seen, row=row, shown=shown, title=f"{title}: {LEFT}"),
    ]


def _drawn_panels(draws: Sequence[Callable[[Axes], None]]) -> Figure:
    with style.figure_style():
        figure, panels = style.panel_grid(len(draws), 2)
        for draw, axes in zip(draws, panels, strict=True):
            draw(axes)
        lines = {str(line.get_label()): line for axes in panels for line in axes.lines}
        style.figure_legend(figure, [lines[name] for name in (MEASURED, BEFORE, AFTER, LEFT)])
    return figure


def _worst_rows(gaps: dict[str, float], names: Sequence[str]) -> list[str]:
    return sorted((name for name in gaps if name in names), key=lambda name: -gaps[name])


def _draw_hits(diagnosis: Diagnosis, campaign: Campaign) -> list[Block]:
    hits = [b for b in campaign.blocks if b.test == "impact" and b.drive_point is not None]
    pieces = {f"impact_p{b.drive_point:02d}" for b in hits}
    worst = _worst_rows(diagnosis.gap.by_record, sorted(pieces))[:1]
    return [b for b in hits if f"impact_p{b.drive_point:02d}" in worst]


def _draw_sine(diagnosis: Diagnosis, campaign: Campaign) -> Block | None:
    sines = {b.name: b for b in campaign.blocks if b.test == "sine" and b.frequency_hz and b.drive_point is not None}
    worst = _worst_rows(diagnosis.gap.by_record, list(sines))
    return sines[worst[0]] if worst else None


def _record_pair(block: Block, campaign: Campaign, twins: tuple[Twin, Twin]) -> _RecordPair:
    last = float(max(1, *(b.order for b in campaign.blocks)))
    before, after = (predict_record(twin, campaign.rig, block, last) for twin in twins)
    return _RecordPair(tuple(campaign.rig.responses), to_signals(block, campaign.rig), before, after)


def _draw_frf(axes: Axes, seen: Sequence[_RecordPair], row: int, title: str) -> None:
    rate, n = seen[0].signals.rate_hz, seen[0].signals.force.size
    forces = np.array([np.fft.rfft(windowed_force(s.signals.force, s.signals.hit)) for s in seen])
    hz = np.fft.rfftfreq(n, 1 / rate)
    shown = (hz > 0) & (hz < BAND * rate)
    power = np.sum(np.abs(forces) ** 2, axis=0)

    def estimate(rows: Sequence[Real]) -> Complex:
        spectra = np.fft.rfft(np.array(rows), axis=1)
        return (np.sum(forces.conj() * spectra, axis=0) / power)[shown]

    measured, before, after = (
        estimate(rows)
        for rows in (
            [s.signals.responses[row] for s in seen],
            [s.before[row] for s in seen],
            [s.after[row] for s in seen],
        )
    )
    curves = [np.abs(v) for v in (measured, before, after)]
    _draw_three_curves(axes, hz[shown], curves)
    axes.plot(hz[shown], np.abs(measured - after), label=LEFT, **_LEFT)
    style.make_logarithmic(axes)
    style.make_logarithmic(axes, "x")
    low, high = axes.get_ylim()
    axes.set_ylim(max(low, float(min(c.min() for c in curves)) / BELOW), high)
    style.label_axes(axes, title, "frequency [Hz]", f"response per force [{_per_force(seen[0], row)}]")


def _draw_record(axes: Axes, seen: _RecordPair, row: int, shown: slice, title: str) -> None:
    curves = [seen.signals.responses[row], seen.before[row], seen.after[row]]
    _draw_three_curves(axes, _milliseconds(seen, shown), [c[shown] for c in curves])
    style.label_axes(axes, title, "time [ms]", f"response [{_unit_of_row(seen, row)}]")


def _draw_residual(axes: Axes, seen: _RecordPair, row: int, shown: slice, title: str) -> None:
    left = seen.signals.responses[row] - seen.after[row]
    axes.plot(_milliseconds(seen, shown), left[shown], label=LEFT, **_LEFT)
    style.label_axes(axes, title, "time [ms]", f"measured less simulated [{_unit_of_row(seen, row)}]")


def _unit_of_row(seen: _RecordPair, row: int) -> str:
    return SI_UNIT[seen.responses[row].quantity].replace("^2", "²")


def _per_force(seen: _RecordPair, row: int) -> str:
    unit = _unit_of_row(seen, row)
    return f"({unit})/N" if "/" in unit else f"{unit}/N"


def _milliseconds(seen: _RecordPair, shown: slice) -> Real:
    times_ms: Real = np.arange(seen.signals.force.size, dtype=np.float64) * (1e3 / seen.signals.rate_hz)
    return times_ms[shown]


_LEFT: dict[str, Any] = {"color": style.WARNING, "linewidth": 0.9}


def _draw_three_curves(axes: Axes, at: NDArray[np.floating[Any]], curves: Sequence[NDArray[np.floating[Any]]]) -> None:
    looks: tuple[tuple[str, dict[str, Any]], ...] = (
        (MEASURED, {"color": style.MEASURED, "linewidth": 3.6, "alpha": 0.5}),
        (BEFORE, {"color": style.SOFT, "linewidth": 1.0}),
        (AFTER, {"color": style.MODEL, "linewidth": 1.5, "linestyle": "--"}),
    )
    for (name, look), values in zip(looks, curves, strict=True):
        axes.plot(at, values, label=name, **look)


def _about_hit(seen: _RecordPair) -> slice:
    first = max(0, seen.signals.hit.first - round(0.005 * seen.signals.rate_hz))
    return slice(first, first + round(HIT_S * seen.signals.rate_hz))


def _time_of_periods(seen: _RecordPair) -> slice:
    hz = seen.signals.block.frequency_hz or 1.0
    return slice(0, min(seen.signals.force.size, round(PERIODS * seen.signals.rate_hz / hz)))
