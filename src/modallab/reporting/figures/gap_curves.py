"""What was measured, what was simulated before and after a diagnosis, and what is left, where it matters most."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.gap.model.predicted_records import predict_record
from modallab.gap.report.calibrated import believed_twin, diagnosed_twin
from modallab.reporting.figures import style
from modallab.signals.hit import windowed_force
from modallab.signals.signals import Signals, to_signals
from modallab.twin.bench import Twin

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

PERIODS = 4
"""Periods of a sine that are shown."""
HIT_S = 0.12
"""Length of a hit's record that is shown."""
BAND = 0.2
"""Share of the rate up to which FRFs are shown."""


@dataclass(frozen=True, eq=False, slots=True)
class _Seen:
    """A record measured and simulated, (channels, n) each."""

    signals: Signals
    before: Array
    after: Array


def gap_curves(diagnosis: Diagnosis, campaign: Campaign) -> Figure | None:
    """FRFs and records of the channel with the largest gap; None where no record can be simulated.

    Panels: the FRF from the hits that are off most, on that channel and at the driving point; one of those hits, and
    the sine block that is off most, in time. Each with measured, simulated as the rig file has it, simulated after the
    diagnosis, and measured less the last.
    """
    twins = believed_twin(campaign.rig), diagnosed_twin(diagnosis, campaign.rig, of_others=False)
    channel = _worst(diagnosis.gap.by_channel, [c.name for c in campaign.rig.responses])
    if channel is None:
        return None
    row = [c.name for c in campaign.rig.responses].index(channel)
    draws: list[Callable[[Axes], None]] = []
    hits = _hits(diagnosis, campaign)
    if hits:
        seen = [_seen(b, campaign, twins) for b in hits]
        draws.append(lambda axes: _frf(axes, seen, row, f"{channel}, hits at point {hits[0].drive_point}"))
        driving = [i for i, c in enumerate(campaign.rig.responses) if c.point == hits[0].drive_point]
        if driving and driving[0] != row:
            name = campaign.rig.responses[driving[0]].name
            draws.append(lambda axes: _frf(axes, seen, driving[0], f"{name}, the driving point"))
        draws.append(lambda axes: _record(axes, seen[0], row, _about_hit(seen[0]), f"{channel}, {hits[0].name}"))
    sine = _sine(diagnosis, campaign)
    if sine is not None:
        one = _seen(sine, campaign, twins)
        draws.append(lambda axes: _record(axes, one, row, _periods(one), f"{channel}, {sine.name}"))
    return _drawn(draws) if draws else None


def _drawn(draws: Sequence[Callable[[Axes], None]]) -> Figure:
    with style.look():
        figure, panels = style.grid(len(draws), min(2, len(draws)))
        for draw, axes in zip(draws, panels, strict=True):
            draw(axes)
        style.legend(figure, panels[0].lines)
    return figure


def _worst(gaps: dict[str, float], names: Sequence[str]) -> str | None:
    known = {name: gap for name, gap in gaps.items() if name in names}
    return max(known, key=lambda name: known[name]) if known else None


def _hits(diagnosis: Diagnosis, campaign: Campaign) -> list[Block]:
    hits = [b for b in campaign.blocks if b.test == "impact" and b.drive_point is not None]
    pieces = {f"impact_p{b.drive_point:02d}" for b in hits}
    worst = _worst(diagnosis.gap.by_record, sorted(pieces))
    return [b for b in hits if f"impact_p{b.drive_point:02d}" == worst]


def _sine(diagnosis: Diagnosis, campaign: Campaign) -> Block | None:
    sines = {b.name: b for b in campaign.blocks if b.test == "sine" and b.frequency_hz and b.drive_point is not None}
    worst = _worst(diagnosis.gap.by_record, list(sines))
    return None if worst is None else sines[worst]


def _seen(block: Block, campaign: Campaign, twins: tuple[Twin, Twin]) -> _Seen:
    last = float(max(1, *(b.order for b in campaign.blocks)))
    before, after = (predict_record(twin, campaign.rig, block, last) for twin in twins)
    return _Seen(to_signals(block, campaign.rig), before, after)


def _frf(axes: Axes, seen: Sequence[_Seen], row: int, title: str) -> None:
    rate, n = seen[0].signals.rate_hz, seen[0].signals.force.size
    forces = np.array([np.fft.rfft(windowed_force(s.signals.force, s.signals.hit)) for s in seen])
    hz = np.fft.rfftfreq(n, 1 / rate)
    shown = (hz > 0) & (hz < BAND * rate)
    power = np.sum(np.abs(forces) ** 2, axis=0)

    def estimate(rows: Sequence[Array]) -> Complex:
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
    _four(axes, hz[shown], [np.abs(v) for v in (measured, before, after, measured - after)])
    style.logarithmic(axes)
    style.label(axes, title, "frequency [Hz]", "response per force")


def _record(axes: Axes, seen: _Seen, row: int, shown: slice, title: str) -> None:
    measured = seen.signals.responses[row]
    t = 1e3 * np.arange(len(measured)) / seen.signals.rate_hz
    curves = [measured, seen.before[row], seen.after[row], measured - seen.after[row]]
    _four(axes, t[shown], [c[shown] for c in curves])
    style.label(axes, title, "time [ms]", "response [SI]")


def _four(axes: Axes, at: NDArray[np.floating[Any]], curves: Sequence[NDArray[np.floating[Any]]]) -> None:
    looks: tuple[tuple[str, dict[str, Any]], ...] = (
        ("measured", {"color": style.MEASURED, "linewidth": 3.6, "alpha": 0.5}),
        ("simulated before", {"color": style.SOFT, "linewidth": 1.0}),
        ("simulated after", {"color": style.MODEL, "linewidth": 1.5, "linestyle": "--"}),
        ("measured less after", {"color": style.WARNING, "linewidth": 0.8}),
    )
    for (name, look), values in zip(looks, curves, strict=True):
        axes.plot(at, values, label=name, **look)


def _about_hit(seen: _Seen) -> slice:
    first = max(0, seen.signals.hit.first - round(0.005 * seen.signals.rate_hz))
    return slice(first, first + round(HIT_S * seen.signals.rate_hz))


def _periods(seen: _Seen) -> slice:
    hz = seen.signals.block.frequency_hz or 1.0
    return slice(0, min(seen.signals.force.size, round(PERIODS * seen.signals.rate_hz / hz)))
