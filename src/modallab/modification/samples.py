"""Samples of a structure that is known with uncertainty.

What the model's own standard deviations say of noise is the smaller part. Sensitivities, and sensors and hits beside
their points, change modal constants by what the rig file states of them.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.core.rig import FORCE_SHARE, Rig, Tolerance
from modallab.modification.outside_band import SQUARES, draw_residual_terms
from modallab.modification.shapes import shapes_of
from modallab.modification.structure import Structure, modes_of, structure_of

COUNT = 200
"""Enough to know a standard deviation to 5 %."""
OUTSIDE_MEASURED = 0.1
"""By how much, one deviation, residual terms of measured pairs may be off: they also take up what else a fit leaves."""
OUTSIDE_ESTIMATED = 0.5
"""The same of pairs that were not measured, in what driven columns tell of them."""

RESOLVED_HZ = 1e-5
"""Frequencies that differ by less are of the same model, computed on another machine."""


def sample_structures(model: ModalModel, rig: Rig | None = None, count: int = COUNT) -> Structure:
    """Structures (samples, ...) that the model and the tolerances of its rig leave possible.

    Args:
        model: with its standard deviations; what has none is taken as exact.
        rig: with tolerances, axes and places; None where nothing is known of them.
        count: how many; the same model gives the same samples.

    Raises:
        DataError: as of `structure_of`.
    """
    nominal, rng = structure_of(model, rig), np.random.default_rng(_seed_of_model(model))
    noise = rng.standard_normal
    hz = model.frequency_hz + np.nan_to_num(model.frequency_sigma_hz) * noise((count, model.n_modes))
    if rig is not None:
        # What is predicted is built at another time: until then stiffness may drift as it does within a test.
        hz = hz * (1 + rig.tolerance.stiffness_drift / 2 * noise((count, 1)))
    zeta = model.damping_ratio + np.nan_to_num(model.damping_sigma) * noise((count, model.n_modes))
    constants = model.modal_constants + _add_noise(model, noise, count)
    constants = constants * _uncertain_gains(model, rig, noise, count)
    if rig is not None:
        constants = constants + _off_points(model, rig, nominal, noise, count)
    rows, columns = freedom_indices(model, nominal)
    sampled = [
        modes_of(h, np.maximum(z, 0), a, rows, columns, len(nominal.freedoms))
        for h, z, a in zip(hz, zeta, constants, strict=True)
    ]
    off = np.where(nominal.known, OUTSIDE_MEASURED, OUTSIDE_ESTIMATED) * noise((count, 1, 1, 1))
    followed = nominal.residual - nominal.alone[:, :, None] * np.eye(len(nominal.freedoms))
    residual = followed * (1 + off) + draw_residual_terms(nominal.alone, noise((count, len(nominal.freedoms), SQUARES)))
    return replace(
        nominal, poles=np.array([p for p, _ in sampled]), psi=np.array([q for _, q in sampled]), residual=residual
    )


def _seed_of_model(model: ModalModel) -> list[int]:
    """Of each model its own: what is uncertain of two structures has nothing in common."""
    return [int(n) for n in np.floor(model.frequency_hz / RESOLVED_HZ)]


def freedom_indices(model: ModalModel, structure: Structure) -> tuple[list[int], list[int]]:
    """Places of a model's outputs and inputs among the freedoms of its structure."""
    # Outputs come first among the freedoms, each with one of its own.
    columns = [structure.index((int(p or 0), structure.drive_axis)) for p in model.input_points]
    return list(range(len(model.outputs))), columns


def _add_noise(model: ModalModel, noise: Any, count: int) -> Complex:
    shape = (count, *model.modal_constants.shape)
    parts = model.modal_constant_part_sigma
    if parts is None:
        even = np.nan_to_num(model.modal_constant_sigma) / np.sqrt(2)
        parts = even + 1j * even
    return np.asarray(np.nan_to_num(parts.real) * noise(shape) + 1j * np.nan_to_num(parts.imag) * noise(shape))


def _uncertain_gains(model: ModalModel, rig: Rig | None, noise: Any, count: int) -> Real:
    """(samples, modes, outputs, inputs) factors by what sensitivities and hits are uncertain by."""
    tolerance = Tolerance() if rig is None else rig.tolerance
    scale = model.scale_uncertainty
    usual = np.full(len(model.outputs), tolerance.sensitivity)
    responses = usual if scale is None else np.where(np.isfinite(scale.responses), scale.responses, usual)
    force = FORCE_SHARE * tolerance.sensitivity if scale is None or scale.force is None else scale.force
    of_force = force * noise((count, 1, 1)) + tolerance.hit_gain * _mean_of_hits(model, noise, count)
    return np.asarray(
        (1 + responses * noise((count, len(model.outputs))))[:, None, :, None] * (1 + of_force)[:, :, None, :]
    )


def _mean_of_hits(model: ModalModel, noise: Any, count: int) -> Real:
    """(samples, modes, inputs) what differs from hit to hit by 1, in the mean over the hits that each mode is of."""
    shares = model.hit_shares
    if shares is None:
        # As of one hit.
        shares = np.ones((model.n_modes, len(model.input_points), 1))
    return np.asarray(np.einsum("rih,sih->sri", shares, noise((count, *shares.shape[1:]))))


def _off_points(model: ModalModel, rig: Rig, nominal: Structure, noise: Any, count: int) -> Complex:
    """(samples, modes, outputs, inputs) what sensors and hits beside their points add to modal constants."""
    try:
        shapes = shapes_of(model, rig)
    except DataError:
        return np.zeros((1, *model.modal_constants.shape), np.complex128)
    # (freedoms, 2, modes): a surface has two directions.
    slopes = np.array([shapes.slopes(f) for f in nominal.freedoms])
    rows, columns = freedom_indices(model, nominal)
    sensor = rig.tolerance.position_m * noise((count, len(rows), 2))
    hit = rig.tolerance.hit_position_m * np.stack([_mean_of_hits(model, noise, count) for _ in range(2)], axis=-1)
    both = (shapes.seen + shapes.driven) / 2
    at_outputs = np.einsum("soj,ojr,ri->sroi", sensor, slopes[rows], both[:, columns])
    return np.asarray(at_outputs + np.einsum("srij,ro,ijr->sroi", hit, both[:, rows], slopes[columns]))
