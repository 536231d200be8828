"""A measured model beside another one of the same structure, such as a finite-element model: which modes are the same.

Pairs are those that make the sum of MAC largest (Allemang, "The modal assurance criterion: twenty years of use and
abuse", Sound and Vibration, August 2003, 14).
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.identification.selection.criteria import comac, mac
from modallab.modification.freedoms import Freedom
from modallab.modification.known import KnownStructure

PAIRED = 0.5
"""MAC below which two modes are no pair."""


@dataclass(frozen=True, eq=False, slots=True)
class ModelCorrelation:
    """Modes of two models over the freedoms that both have.

    Attributes:
        freedoms: (freedoms,) point and axis.
        mac: (modes of one, modes of the other).
        pairs: (pairs,) places of a mode in the one and in the other, from 0.
        frequency_hz: (pairs, 2).
        frequency_sigma_hz: (pairs, 2) one standard deviation; NaN where not known.
        damping_ratio: (pairs, 2).
        damping_sigma: (pairs, 2).
        comac: (freedoms,) low where a freedom disagrees in many modes.
        alone: (2,) places of the modes that only one has.
        shapes: (2, pairs, freedoms) of both, 1 at the largest of the one, the other in its phase and of its size.
    """

    freedoms: tuple[Freedom, ...]
    mac: Real
    pairs: tuple[tuple[int, int], ...]
    frequency_hz: Real
    frequency_sigma_hz: Real
    damping_ratio: Real
    damping_sigma: Real
    comac: Real
    alone: tuple[tuple[int, ...], tuple[int, ...]]
    shapes: Complex


def correlate_models(one: KnownStructure, other: KnownStructure) -> ModelCorrelation:
    """The pairs of two models, over all points that have a sensor or were driven in both.

    Raises:
        DataError: fewer than two common points, no driving point, or no pair.
    """
    common = tuple(f for f in one.structure.freedoms if f in other.structure.freedoms)
    if len(common) < 2:
        raise DataError(
            f"the models share {len(common)} points", remedy="compare models with two common points and axes at least"
        )
    a, b = (k.structure.psi[:, [k.structure.freedoms.index(f) for f in common]] for k in (one, other))
    found = mac(a, b)
    rows, columns = linear_sum_assignment(-found)
    pairs = tuple((int(i), int(j)) for i, j in zip(rows, columns, strict=True) if found[i, j] >= PAIRED)
    if not pairs:
        raise DataError(
            f"no two modes are alike: the largest MAC is {found.max():.2f}", remedy="check points, axes and bands"
        )
    first, second = [i for i, _ in pairs], [j for _, j in pairs]
    both = {
        name: np.stack([getattr(one.model, name)[first], getattr(other.model, name)[second]], axis=1)
        for name in ("frequency_hz", "frequency_sigma_hz", "damping_ratio", "damping_sigma")
    }
    alone = tuple(r for r in range(len(a)) if r not in first), tuple(r for r in range(len(b)) if r not in second)
    shapes = _at_one_size(a[first], b[second])
    return ModelCorrelation(
        freedoms=common, mac=found, pairs=pairs, comac=comac(a[first], b[second]), alone=alone, shapes=shapes, **both
    )


def _at_one_size(one: Complex, other: Complex) -> Complex:
    largest = np.take_along_axis(one, np.argmax(np.abs(one), axis=1)[:, None], axis=1)
    factor = np.sum(other.conj() * one, axis=1) / np.sum(np.abs(other) ** 2, axis=1)
    return np.stack([one, factor[:, None] * other]) / largest
