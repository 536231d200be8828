"""A fit of the FRFs of a random force, taken on to the records that they were made of."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.frf import Frf
from modallab.core.units import FrfEstimator
from modallab.frf.joined import RecordSpectra
from modallab.identification.likelihood.derivatives import poles_of
from modallab.identification.likelihood.driven_records import OF_H2, DrivenFit, DrivenModel
from modallab.identification.likelihood.equations import ParameterCovariance
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.frf_fit import fit_frf
from modallab.identification.model.modal_model import FitReadings, readings_of_fit


@dataclass(frozen=True, eq=False, slots=True)
class FitToRecords:
    """The most likely model of records.

    Attributes:
        fit: of the FRFs, with the poles of the records and their covariance.
        stay: (modes,) which modes of the fit of the FRFs it holds.
        seen: what else a model takes.
        notes: what is to be said of the noise on the force.
    """

    fit: LikelihoodFit
    stay: NDArray[np.int64]
    seen: FitReadings
    notes: tuple[str, ...]


def fit_on_records(
    frf: Frf, fit: LikelihoodFit, keep: NDArray[np.bool_], records: RecordSpectra, estimator: FrfEstimator
) -> FitToRecords:
    """The most likely model of records, without the modes that only the fit of the FRFs needs.

    Args:
        frf: of one force.
        fit: of them.
        keep: (modes,) which poles are modes.
        records: of that force.
        estimator: whose the noise on the force is taken to be.

    Raises:
        IdentificationError: poles that cannot be distinguished.
    """
    problem, at = fit.problem, fit.point.parameters
    driven = DrivenFit(records, problem.powers, problem.blocks[0].excitation.grid.p, estimator)
    found = driven.search(at.omega, at.zeta, fit.point.groups[0].coefficients)
    found, stay = driven.needed(found, keep)
    there, n = fit_frf(frf, poles_of(found.omega, found.zeta), 0, stand_ins=()), 2 * stay.size
    covariance = ParameterCovariance.of_poles(found.covariance[:n, :n])
    refined = replace(there.refined, covariance=covariance, settled=True)
    better = replace(there, refined=refined)
    constants, sigma = _modal_constants(found)
    noise = float(np.median(1 - driven.true_share(found.force_noise)))
    parts = _with_bias(constants, sigma, noise, estimator)
    seen = replace(
        readings_of_fit(better), constants=constants, sigma_of_parts=parts, terms=found.coefficients[n:, :, None]
    )
    known = float(np.min(np.abs(sigma) / np.maximum(np.abs(constants), np.finfo(float).tiny), initial=np.inf))
    return FitToRecords(better, stay, seen, _noise_note(noise, estimator, known))


def _modal_constants(found: DrivenModel) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Modal constants and their sigmas, each (modes, outputs, 1), as `LikelihoodFit.modal_constants` has them."""
    n, size = 2 * found.omega.size, found.coefficients.size
    sigma = np.sqrt(np.diag(found.covariance)[n : n + size]).reshape(found.coefficients.shape[::-1]).T
    scale = 2 * poles_of(found.omega, found.zeta).imag[:, None, None]
    values, sigmas = (part[:n].reshape(found.omega.size, 2, -1) for part in (found.coefficients, sigma))
    residue = values[:, 0] + 1j * values[:, 1]
    return 1j * scale * residue[..., None], scale * (sigmas[:, 1] + 1j * sigmas[:, 0])[..., None]


def _with_bias(
    constants: NDArray[np.complex128], sigma: NDArray[np.complex128], noise: float, estimator: FrfEstimator
) -> NDArray[np.complex128]:
    """Sigmas of the parts with that of the bias, which is one of two that the records do not choose between.

    Noise on the force channel makes the constants too low by one share of the noise's power, a force that was not
    measured makes them too high by the rest of it. Either is as likely: the bias counts by the mean of their squares.
    """
    of_h2 = OF_H2[estimator]
    bias = noise * np.sqrt(((1 - of_h2) ** 2 + of_h2**2) / 2)
    return np.hypot(sigma.real, bias * constants.real) + 1j * np.hypot(sigma.imag, bias * constants.imag)


def _noise_note(noise: float, estimator: FrfEstimator, known: float) -> tuple[str, ...]:
    """A bias that the best known modal constant would not show is not worth a word."""
    if noise < known:
        return ()
    low, high = 100 * noise * (1 - OF_H2[estimator]), 100 * noise * OF_H2[estimator]
    on_channel = f"{estimator} and the modal constants are {low:.2g} % low" if low else f"{estimator} is right"
    in_force = f"they are {high:.2g} % high" if high else "they are right"
    return (
        f"Noise on the force, {100 * np.sqrt(noise):.2g} % of it, is in the uncertainties, as is its bias. If the "
        f"force channel makes it, {on_channel}. If it is a force that was not measured, {in_force}.",
    )
