"""The same mode in several tests, beside the truth: what tables and figures of modes are made from."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, isfinite, nan
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.core.model import ModalModel
from modallab.core.units import Test
from modallab.identification.selection.pairing import nearest
from modallab.reporting.content import Truth

Confidence = NDArray[np.float64] | None
"""(modes,) of one model, 0 to 1; None where it was not judged."""
Verdict = Literal["agree", "borderline", "disagree", "unknown"]


@dataclass(frozen=True, slots=True)
class Reading:
    """One mode as one test saw it. Unknown numbers are NaN; damping is a ratio, zeta; confidence is 0 to 1."""

    test: Test | None
    frequency_hz: float
    frequency_sigma_hz: float
    damping: float
    damping_sigma: float
    half_power: float
    half_power_floor: float
    confidence: float = nan


@dataclass(frozen=True, slots=True)
class Mode:
    """One mode, in every test that saw it, with the truth where it is known (else NaN)."""

    number: int
    readings: tuple[Reading, ...]
    true_frequency_hz: float = nan
    true_damping: float = nan

    @property
    def frequency_hz(self) -> float:
        """The frequency to call it by: the first test's."""
        return self.readings[0].frequency_hz

    @property
    def best(self) -> Reading:
        """The reading with the smallest sigma of damping."""
        known = [r for r in self.readings if isfinite(r.damping_sigma)]
        return min(known, key=lambda r: r.damping_sigma) if known else self.readings[0]


def modes(
    models: Sequence[ModalModel], truth: Truth | None = None, confidence: Sequence[Confidence] = ()
) -> tuple[Mode, ...]:
    """The modes of all tests, matched by frequency, ascending.

    Args:
        models: one a test; the first decides what the modes are called, others add what it did not see.
        truth: the modes of a simulated bench.
        confidence: one a model, in their order, or none at all.
    """
    groups: list[list[Reading]] = []
    for i, model in enumerate(models):
        readings = _readings(model, confidence[i] if confidence else None)
        partner = nearest([g[0].frequency_hz for g in groups], [r.frequency_hz for r in readings])
        taken = {there: here for here, there in enumerate(partner) if there is not None}
        fresh = [[r] for i, r in enumerate(readings) if i not in taken]
        for place, here in taken.items():
            groups[here].append(readings[place])
        groups += fresh
    groups.sort(key=lambda group: group[0].frequency_hz)
    true = _truths([g[0].frequency_hz for g in groups], truth)
    return tuple(Mode(i + 1, tuple(g), *true[i]) for i, g in enumerate(groups))


def deviation(a: float, a_sigma: float, b: float, b_sigma: float) -> float:
    """How many joint standard deviations lie between two values; NaN where a sigma is not known."""
    sigma = hypot(a_sigma, b_sigma)
    return abs(a - b) / sigma if sigma > 0 else nan


def verdict(deviations: float) -> Verdict:
    """In words: up to 2 sigma agree (19 of 20 good pairs do), past 3 disagree (1 of 370 good pairs would)."""
    if not isfinite(deviations):
        return "unknown"
    return "agree" if deviations <= 2 else "borderline" if deviations <= 3 else "disagree"


def _readings(model: ModalModel, confidence: Confidence) -> list[Reading]:
    columns = (
        model.frequency_hz,
        model.frequency_sigma_hz,
        model.damping_ratio,
        model.damping_sigma,
        model.half_power,
        model.half_power_floor,
        np.full(model.n_modes, nan) if confidence is None else confidence,
    )
    return [Reading(model.test, *(float(c[i]) for c in columns)) for i in range(model.n_modes)]


def _truths(frequency_hz: list[float], truth: Truth | None) -> list[tuple[float, float]]:
    if truth is None:
        return [(nan, nan)] * len(frequency_hz)
    places = nearest(frequency_hz, truth.frequency_hz)
    return [(nan, nan) if j is None else (float(truth.frequency_hz[j]), float(truth.damping_ratio[j])) for j in places]
