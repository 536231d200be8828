"""By how much errors at a joint grow where two structures are held together, or one is taken away."""

import numpy as np

from modallab.core.arrays import Complex
from modallab.modification.coupled import CouplingToStructure
from modallab.modification.structure import Structure

LINES = 200
"""Across the band: enough for a median beside resonances."""


def conditioning_of(structure: Structure, part: CouplingToStructure) -> float:
    """By which factor relative errors of receptances at a joint grow in its forces, the median over the band.

    Forces solve F g = u with F = H + Y, of both structures. They are off by the spectral radius of |F^-1| (|H| + |Y|),
    in the scaling of pairs in which that is least (Bauer, Numerische Mathematik 5 (1963), 73). Where one structure
    nearly alone says how the joint moves, and is taken away, H and Y cancel.

    Args:
        structure: without the part, or with it where it is taken away.
        part: what is held to it or taken away.

    Returns:
        From 1 on.
    """
    b = part.links(structure)
    s = 2j * np.pi * np.linspace(*structure.band_hz, LINES + 1)[1:]
    own, other = structure.receptance(s, b, b), part.compliance(s)
    return float(np.median([_error_growth(h, y) for h, y in zip(own, other, strict=True)]))


def _error_growth(own: Complex, other: Complex) -> float:
    if np.linalg.matrix_rank(own + other) < len(own):
        return np.inf
    return float(np.max(np.abs(np.linalg.eigvals(np.abs(np.linalg.inv(own + other)) @ (np.abs(own) + np.abs(other))))))
