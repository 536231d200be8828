"""A structure after a change: its modes, shapes and FRFs, each with its uncertainty."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr

from modallab.core.arrays import Complex, Real
from modallab.modification.attachments import AttachedPart
from modallab.modification.poles import StructureWithAttachments, poles_of, refine_poles
from modallab.modification.structure import Structure

CIRCLE = 8
"""Points about a pole, over which its residue is the mean: exact but for the eighth power of radius over distance."""
RADIUS = 1e-3
"""Of that circle, in frequencies of the pole, where no other pole is near."""


@dataclass(frozen=True, eq=False, slots=True)
class ModifiedModes:
    """Modes of a structure after a change, within the band of its model.

    Attributes:
        frequency_hz: (modes,) undamped natural frequency, rising.
        damping_ratio: (modes,)
        frequency_sigma_hz: (modes,) one standard deviation.
        damping_sigma: (modes,)
        psi: (modes, freedoms) such that psi psi^T is the residue.
        like: (modes,) the mode before whose shape it resembles most, from 0.
        mac: (modes,) of the two shapes.
        outside: (modes,) by which share of the larger frequency what lies outside the band moves it; 1 where a mode is
            of that alone.
        hidden: modes that left the band, which the model cannot tell.
    """

    frequency_hz: Real
    damping_ratio: Real
    frequency_sigma_hz: Real
    damping_sigma: Real
    psi: Complex
    like: NDArray[np.intp]
    mac: Real
    outside: Real
    hidden: int


def modified_modes(
    structure: Structure,
    changes: Sequence[AttachedPart],
    samples: Structure | None = None,
    before: Structure | None = None,
) -> ModifiedModes:
    """The modes of a structure with changes.

    Args:
        structure: before.
        changes: what is hung on it.
        samples: (samples, ...) of the same structure, for the uncertainty; without them it is NaN.
        before: to compare shapes with; None for the structure.

    Raises:
        DataError: the model does not know a point.
    """
    attached = StructureWithAttachments.of(structure, changes)
    every = poles_of(attached)
    inside = (np.abs(every) <= 2 * np.pi * structure.band_hz[1]) & (every.imag > 0)
    poles = every[inside]
    psi = residues_of(attached, poles)
    like, mac = _most_similar_modes((before or structure).psi, psi)
    size = np.abs(poles)
    hz, zeta = size / (2 * np.pi), -poles.real / size
    sigma = np.full((2, poles.size), np.nan)
    if samples is not None:
        sigma = _relative_deviations(attached.with_samples(samples), poles)
        if all(getattr(change, "damper", 0.0) >= 0 for change in changes):
            zeta, sigma[1] = passive_damping(zeta, sigma[1])
    return ModifiedModes(
        frequency_hz=hz,
        damping_ratio=zeta,
        frequency_sigma_hz=sigma[0] * hz,
        damping_sigma=sigma[1],
        psi=psi,
        like=like,
        mac=mac,
        outside=_moved_from_outside(attached, poles),
        hidden=max(len(structure.poles) - poles.size, 0),
    )


def passive_damping(zeta: Real, sigma: Real) -> tuple[Real, Real]:
    """Damping ratios and deviations, of which is known that none is below 0: the normal distribution cut off there.

    After large shifts phases of shapes make a damping ratio less certain than its size. One below 0 is wrong by at
    least as much, whatever its deviation says.

    Args:
        zeta: (modes,)
        sigma: (modes,) one standard deviation.

    Returns:
        (modes,) mean and (modes,) deviation (Johnson, Kotz, Continuous Univariate Distributions (1994), 13.10).
    """
    sigma = np.hypot(sigma, np.minimum(zeta, 0))
    least = np.maximum(sigma, np.finfo(np.float64).eps)
    from_zero = zeta / least
    more = np.exp(-(from_zero**2) / 2 - np.log(2 * np.pi) / 2 - log_ndtr(from_zero))
    left = np.sqrt(np.maximum(1 - more * (more + from_zero), 0))
    return np.asarray(zeta + least * more), np.asarray(sigma * left)


def _moved_from_outside(attached: StructureWithAttachments, poles: Complex) -> Real:
    """(poles,) share of the larger frequency between those with and without residual terms."""
    structure = attached.structure
    modes_only = attached.with_structure(replace(structure, residual=0 * structure.residual))
    with_all, without = np.abs(poles), np.abs(refine_poles(modes_only, poles))
    return np.asarray(np.abs(with_all - without) / np.maximum(with_all, without))


def _relative_deviations(attached: StructureWithAttachments, nominal: Complex) -> Real:
    """(2, poles) relative deviation of frequencies, and that of damping ratios, over samples."""
    found = refine_poles(attached, np.broadcast_to(nominal, (len(attached.structure.poles), nominal.size)))
    size = np.abs(found)
    return np.array([np.std(np.log(size), axis=0), np.std(-found.real / size, axis=0)])


def residues_of(attached: StructureWithAttachments, poles: Complex) -> Complex:
    """(poles, freedoms) psi with psi psi^T the residue at each pole, a mean over a small circle about it."""
    angles = np.exp(2j * np.pi * np.arange(CIRCLE) / CIRCLE)
    apart = np.abs(poles[:, None] - poles) + np.diag(np.full(len(poles), np.inf))
    radius = np.minimum(RADIUS * np.abs(poles), 0.2 * apart.min(axis=1, initial=np.inf))
    s = poles[:, None] + radius[:, None] * angles
    n = len(attached.structure.freedoms)
    values = attached.receptance(s.ravel()).reshape(len(poles), CIRCLE, n, n)
    residue = np.einsum("pc,pcoi->poi", radius[:, None] * angles / CIRCLE, values)
    best = np.argmax(np.abs(np.einsum("poo->po", residue)), axis=1)
    column = residue[np.arange(len(poles)), :, best]
    return np.asarray(column / np.sqrt(column[np.arange(len(poles)), best])[:, None])


def _most_similar_modes(before: Complex, after: Complex) -> tuple[NDArray[np.intp], Real]:
    power = np.sum(np.abs(after) ** 2, axis=1)[:, None] * np.sum(np.abs(before) ** 2, axis=1)
    mac = np.abs(after.conj() @ before.T) ** 2 / np.where(power > 0, power, 1.0)
    like = np.argmax(mac, axis=1)
    return like, mac[np.arange(len(like)), like]
