"""Where the force of a law acts, by the overtones alone.

At multiples of a sine's frequency nothing but the law's own force moves the beam, so all accelerometers show one shape
there: the answer of the linear beam to a force, or to a couple, at its place. Neither the law nor its size is needed
(on the shape of what a local nonlinearity adds: Worden and Tomlinson, Nonlinearity in Structural Dynamics, 2001).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.gap.conditioning.overtones import Harmonic
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.fit import Fit
from modallab.gap.search.fitting import Bench
from modallab.gap.search.overtone_lines import FEWEST
from modallab.twin.bench import Twin, chain_transfer
from modallab.twin.candidate import CandidateEffect
from modallab.twin.effect_model import Acts
from modallab.twin.effects import search_of
from modallab.twin.elements import curvature_rows, shape_rows
from modallab.twin.modes import TwinModes, solve_modes
from modallab.twin.predict import sensor_positions

PLACES = 99
"""Places along the beam at which it is tried at first, and about the best of them again."""
SPREAD = 0.04
"""Half width over L of what bends at a crack."""
INEXACT = 0.03
"""Relative error of the shapes: the beam is known to a percent, the sensitivities to one or two."""
MOST = 0.3
"""Share of an overtone's squares beyond which it is as wrong as can be: one resonance must not decide."""

NEARBY = 0.04
"""Share of the length by which a place may be off that the overtones show: where a crack bends is no point."""
STARTS = 5
"""Places that are tried within it."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where a force acts.

    Attributes:
        x: share of the length from the clamp.
        left: share of the overtones' squares that such a force does not make there, mean over the overtones.
    """

    x: float
    left: float


def locate_by_overtones(bench: Bench, base: Fit, candidate: CandidateEffect) -> CandidateEffect:
    """The effect, near the place that the overtones show; as it is where it has no such place or none is clear."""
    acts, free = search_of(candidate.effect).law.acts, bench.free.size
    if acts is None:
        return candidate
    as_believed = np.concatenate([np.zeros(free), base.u[free:]])
    found = place(bench.overtones, [base.problem.twin(u) for u in (base.u, as_believed)], bench.data, acts)
    if found is None:
        return candidate
    low, high = max(found.x - NEARBY, 0.0), min(found.x + NEARBY, 1.0)
    narrow = {"starts": tuple(np.linspace(low, high, STARTS).tolist()), "low": low, "high": high}
    return replace(candidate, slots=tuple(replace(s, **narrow) if s.name == "x" else s for s in candidate.slots))


def place(found: Sequence[Harmonic], twins: Sequence[Twin], data: Reduced, acts: Acts) -> Place | None:
    """The place along the beam at which a force, or a couple, makes the overtones best; None where none is clear.

    Args:
        found: the overtones.
        twins: linear beams the answers of which are tried.
        data: says which channels there are and where.
        acts: what the law does at its place.
    """
    clear = [o for o in found if np.count_nonzero(o.is_clear) >= FEWEST]
    if not clear:
        return None
    tried: list[Place] = []
    for twin in twins:
        modes = solve_modes(twin.structure)
        step = 1 / PLACES
        at = np.linspace(step, 1.0, PLACES)
        for _ in range(2):
            rows = _force_rows(at, twin, acts)
            left = np.mean([_residual_share(o, twin, modes, data, rows) for o in clear], axis=0)
            best = int(np.argmin(left))
            tried.append(Place(float(at[best]), float(left[best])))
            at = np.clip(at[best] + np.linspace(-step, step, 21), 0.0, 1.0)
    return min(tried, key=lambda p: p.left)


def _force_rows(at: Real, twin: Twin, acts: Acts) -> Real:
    """(places, n) over the elements' degrees of freedom."""
    length = twin.structure.length_m
    if acts == "force":
        return shape_rows(at * length, length)
    about = np.linspace(-2, 2, 17)
    weights = np.exp(-(about**2)) / np.sum(np.exp(-(about**2)))
    about_place = np.clip(at[:, None] + SPREAD * about, 0.0, 1.0) * length
    rows = curvature_rows(about_place.ravel(), length).reshape(*about_place.shape, -1)
    return np.einsum("w,pwn->pn", weights, rows)


def _residual_share(overtone: Harmonic, twin: Twin, modes: TwinModes, data: Reduced, rows: Real) -> Real:
    """(places,) share of one overtone's squares that no force there makes."""
    y, shapes = overtone.y, _acceleration(2j * np.pi * overtone.hz, twin, modes, data, rows)
    weight = 1 / np.hypot(overtone.beside, INEXACT * np.max(np.abs(y)))
    y, shapes = y * weight, shapes * weight
    made = np.abs(shapes.conj() @ y) ** 2 / np.maximum(np.sum(np.abs(shapes) ** 2, axis=1), 1e-300)
    return np.minimum(1 - made / np.sum(np.abs(y) ** 2), MOST)


def _acceleration(s: complex, twin: Twin, modes: TwinModes, data: Reduced, rows: Real) -> Complex:
    """(places, channels) acceleration as recorded for a unit of each force."""
    x_m = sensor_positions(twin.chain, modes, data.channels, data.x_m)
    psi, own = modes.shapes_at(x_m), rows @ modes.columns
    moved = (own / (s - modes.poles)) @ psi.T + (own.conj() / (s - modes.poles.conj())) @ psi.conj().T
    moved = moved + rows @ modes.out_of_band @ shape_rows(x_m, modes.length_m).T
    return s**2 * chain_transfer(twin.chain, data.channels, np.array([s]))[:, 0] * moved
