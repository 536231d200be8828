"""What the gap behaves like if the ring-down has a pole more than a beam in bending: a mass that swings on a spring, or
modes beside those of bending.

Where a pole more is taken for one of bending, the whole beam bends to it: each trial begins at the beam that the poles
show once the pole has its own cause.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from modallab.gap.model.fit import Fit, Problem
from modallab.gap.model.prefit import start_fit, start_fits
from modallab.gap.search.fitting import Bench, forgivable_error
from modallab.gap.unknown.fitted import ElementTrial, element
from modallab.twin.candidate import CandidateEffect
from modallab.twin.learned.side_modes import FAMILIES
from modallab.twin.structure import frequency_multiples

PLACES = tuple(float(x) for x in np.linspace(0.1, 0.98, 12))
"""Shares of the length at which a mass on a spring is begun from."""
HUNG = 3
"""Places of a mass on a spring that are fitted in short: those whose poles fit best."""
BESIDE = 3
"""Families of modes beside that are fitted in short: those that take most away to first order."""
MEMBERS = 2
"""Modes of a family, the lowest first, that a pole may be."""


def trials_at_spare_poles(bench: Bench, base: Fit) -> Iterator[ElementTrial]:
    """Elements with modes of their own, begun at the poles of the ring-down."""
    if len(bench.poles):
        yield from _absorbers(bench)
        yield from _side_modes(bench, base)


def _absorbers(bench: Bench) -> Iterator[ElementTrial]:
    candidate = element(bench, "point_law", ("hung_m", "hung_hz", "x"))
    found = []
    for x in PLACES:
        held = candidate.with_fixed_place(x)
        begin = start_fits((held,), bench.free, bench.poles, 1)[0]
        law = held.effect_at(begin.u[bench.free.size :]).parameters
        found.append((begin.cost, (law["hung_m"], law["hung_hz"], x)))
    yield ElementTrial(candidate, tuple(values for _, values in sorted(found)[:HUNG]))


@dataclass(frozen=True, slots=True)
class _Family:
    """A family of modes beside: how much it takes away to first order, and where that begins."""

    takes: float
    candidate: CandidateEffect
    begin: tuple[float, ...]


def _side_modes(bench: Bench, base: Fit) -> Iterator[ElementTrial]:
    floor = forgivable_error(base.problem, base.u)
    found: list[_Family] = []
    for name, family in FAMILIES.items():
        shape = {"alone_power": 1.0} if family == "alone" else {}
        candidate = element(bench, "side_modes", (name, *shape, "kg", "zeta"))
        for pole in bench.poles:
            zeta = max(-float(pole.real) / abs(pole), 1e-3)
            for multiple in frequency_multiples(family)[:MEMBERS]:
                hz = float(abs(pole)) / (2 * np.pi) / float(multiple)
                one = _first_trial(bench, candidate, (hz, *shape.values()), zeta, floor)
                found += [] if one is None else [one]
    best = sorted(found, key=lambda f: -f.takes)[:BESIDE]
    yield from (ElementTrial(f.candidate, (f.begin,)) for f in best)


def _first_trial(
    bench: Bench, candidate: CandidateEffect, first: tuple[float, ...], zeta: float, floor: float
) -> _Family | None:
    """A family at one frequency, its mass as the residual wants it; None where it wants none.

    What it adds goes with the inverse of that mass.
    """
    assert bench.data.rig.beam is not None
    problem = Problem(bench.thin, bench.free, (candidate,), floor)

    def at(kg: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        values = (*first, kg, zeta)
        own = np.array([s.coordinate(v) for s, v in zip(candidate.slots, values, strict=True)])
        return start_fit((candidate,), own, bench.free, bench.poles).u

    kg = bench.data.rig.beam.mass_kg
    u, none = at(kg), at(kg * 1e9)
    none[: bench.free.size] = u[: bench.free.size]
    less, whole = problem.residual(none), problem.residual(u)
    added = whole - less
    size = float(added @ added)
    share = -float(added @ less) / size if size else 0.0
    return _Family(share**2 * size, candidate, (*first, kg / share, zeta)) if share > 0 else None
