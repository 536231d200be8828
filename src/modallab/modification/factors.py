"""Modal constants as products of what a sensor shows of a mode and what a force does to it, both complex."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex


@dataclass(frozen=True, eq=False, slots=True)
class ModalFactors:
    """Of all modes at all freedoms; where only one of the two was measured, the other is as large (reciprocity).

    Attributes:
        seen: (modes, freedoms) what sensors show.
        driven: (modes, freedoms) what forces do, without the common phase.
        turn: factor exp(j phase) that all driving-point constants have in common. At a driving point the constants of
            a structure lie about the real axis; what turns them together is the measuring chain.
        scaled: whether there is a driving point; without one each mode has a scale of its own.
    """

    seen: Complex
    driven: Complex
    turn: complex
    scaled: bool


def factor_constants(constants: Complex, rows: Sequence[int], columns: Sequence[int], n: int) -> ModalFactors:
    """The factors of constants (modes, outputs, inputs) whose outputs and inputs are the freedoms rows and columns."""
    left, size, right = np.linalg.svd(constants, full_matrices=False)
    root = np.sqrt(size[:, :1])
    u, v = left[:, :, 0] * root, right[:, 0] * root
    seen, driven = _mean_at(u, rows, n), _mean_at(v, columns, n)
    both = [f for f in range(n) if f in rows and f in columns]
    total = np.sum(seen[:, both] * driven[:, both])
    turn = complex(total / abs(total)) if abs(total) > 0 else 1.0 + 0.0j
    if both:
        scale = _driving_point_scale(seen[:, both], driven[:, both] / turn)
        seen, driven = seen * scale, driven / scale / turn
    else:
        driven = driven / turn
    only_seen = [f for f in range(n) if f not in columns]
    only_driven = [f for f in range(n) if f not in rows]
    driven[:, only_seen], seen[:, only_driven] = seen[:, only_seen], driven[:, only_driven]
    return ModalFactors(seen, driven, turn, bool(both))


def _driving_point_scale(seen: Complex, driven: Complex) -> Complex:
    """(modes, 1) factor that makes what is seen and driven at the driving points alike, in the mean of squares."""
    square = np.sum(np.conj(seen) * driven, axis=1)
    power = np.sum(np.abs(seen) ** 2, axis=1)
    return np.sqrt(np.where(power > 0, square / np.where(power > 0, power, 1.0), 1.0) + 0j)[:, None]


def _mean_at(values: Complex, places: Sequence[int], n: int) -> Complex:
    """(modes, n) values (modes, listed) at their places, their mean where several stand at one."""
    at = np.equal.outer(np.asarray(places), np.arange(n))
    return values @ (at / np.maximum(at.sum(axis=0), 1))
