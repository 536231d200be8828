"""The same mode in several tests, beside the truth: what tables and figures of modes are made from."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot, isfinite, nan
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.core.model import ModalModel
from modallab.core.units import Test
from modallab.identification.selection.criteria import nearest_partners
from modallab.reporting.content import TrueModes

Confidence = NDArray[np.float64] | None
"""(modes,) of one model, 0 to 1; None where it was not judged."""
Verdict = Literal["agree", "borderline", "disagree", "unknown"]


@dataclass(frozen=True, slots=True)
class ModeReading:
    """One mode as one test saw it, with the truth. Unknown is NaN; damping is a ratio, zeta; confidence is 0 to 1."""

    test: Test | None
    frequency_hz: float
    frequency_sigma_hz: float
    damping: float
    damping_sigma: float
    half_power: float
    half_power_floor: float
    confidence: float = nan
    true_frequency_hz: float = nan
    true_damping: float = nan
    true_drift: float = 0.0


@dataclass(frozen=True, slots=True)
class ComparedMode:
    """One mode, in every test that saw it."""

    number: int
    readings: tuple[ModeReading, ...]

    @property
    def frequency_hz(self) -> float:
        """The frequency to call it by: the first test's."""
        return self.readings[0].frequency_hz

    @property
    def true_frequency_hz(self) -> float:
        """Of the first test's mode; NaN where it is not known."""
        return self.readings[0].true_frequency_hz

    @property
    def true_damping(self) -> float:
        """Of the first test's mode; NaN where it is not known."""
        return self.readings[0].true_damping

    @property
    def best(self) -> ModeReading:
        """The reading with the smallest sigma of damping."""
        known = [r for r in self.readings if isfinite(r.damping_sigma)]
        return min(known, key=lambda r: r.damping_sigma) if known else self.readings[0]


def matched_modes(
    models: Sequence[ModalModel], truth: TrueModes | None = None, confidence: Sequence[Confidence] = ()
) -> tuple[ComparedMode, ...]:
    """The modes of all tests, matched by frequency, ascending.

    Args:
        models: one a test; the first decides what the modes are called, others add what it did not see.
        truth: the modes of a simulated bench.
        confidence: one a model, in their order, or none at all.
    """
    groups: list[list[ModeReading]] = []
    for i, model in enumerate(models):
        readings = _readings_of_model(model, confidence[i] if confidence else None)
        partner = nearest_partners([g[0].frequency_hz for g in groups], [r.frequency_hz for r in readings])
        taken = {there: here for here, there in enumerate(partner) if there is not None}
        fresh = [[r] for i, r in enumerate(readings) if i not in taken]
        for place, here in taken.items():
            groups[here].append(readings[place])
        groups += fresh
    groups.sort(key=lambda group: group[0].frequency_hz)
    if truth is not None:
        groups = _beside_truth(groups, truth)
    return tuple(ComparedMode(i + 1, tuple(g)) for i, g in enumerate(groups))


def joint_deviations(a: float, a_sigma: float, b: float, b_sigma: float) -> float:
    """How many joint standard deviations lie between two values; NaN where a sigma is not known."""
    sigma = hypot(a_sigma, b_sigma)
    return abs(a - b) / sigma if sigma > 0 else nan


def agreement_verdict(deviations: float) -> Verdict:
    """In words: up to 2 sigma agree (19 of 20 good pairs do), past 3 disagree (1 of 370 good pairs would)."""
    if not isfinite(deviations):
        return "unknown"
    return "agree" if deviations <= 2 else "borderline" if deviations <= 3 else "disagree"


def _readings_of_model(model: ModalModel, confidence: Confidence) -> list[ModeReading]:
    columns = (
        model.frequency_hz,
        model.frequency_sigma_hz,
        model.damping_ratio,
        model.damping_sigma,
        model.half_power,
        model.half_power_floor,
        np.full(model.n_modes, nan) if confidence is None else confidence,
    )
    return [ModeReading(model.test, *(float(c[i]) for c in columns)) for i in range(model.n_modes)]


def _beside_truth(groups: Sequence[Sequence[ModeReading]], truth: TrueModes) -> list[list[ModeReading]]:
    """The readings with the truth of their own test, each mode with one and the same true mode."""
    known: list[list[ModeReading]] = []
    for group, place in zip(
        groups, nearest_partners([g[0].frequency_hz for g in groups], truth.frequency_hz), strict=True
    ):
        known.append([r if place is None else _true_reading(r, truth.of(r.test), place) for r in group])
    return known


def _true_reading(reading: ModeReading, truth: TrueModes, place: int) -> ModeReading:
    if place >= len(truth.frequency_hz):
        return reading
    return replace(
        reading,
        true_frequency_hz=float(truth.frequency_hz[place]),
        true_damping=float(truth.damping_ratio[place]),
        true_drift=abs(truth.drift) / 2,
    )
