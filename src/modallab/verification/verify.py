"""Measured against regenerated mobility: the paper's figures 7 and 8."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.core.frf import Frf, FrfQuantity
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.core.verification import Verification
from modallab.frf.estimate import convert, impact_frf
from modallab.frf.stepped import stepped_frf
from modallab.identification.likelihood.excitation import HitExcitation
from modallab.identification.likelihood.fit import Fit
from modallab.identification.likelihood.sine_block import ToneExcitation, tone
from modallab.identification.model.modal_model import receptance
from modallab.signals.bandpass import bandpass, remove_mean
from modallab.signals.block_sets import check_test
from modallab.signals.signals import Signals

FINE_LINES = 2000


def verify_impact(model: ModalModel, fit: Fit, groups: Sequence[Sequence[Signals]], rig: Rig) -> Verification:
    """Both sides through the same block, mean removal, band-pass and H1.

    Args:
        model: the identified model.
        fit: the fit it came from.
        groups: the hits by point, in the order of the fit.
        rig: channels and points.

    Raises:
        DataError: records that cannot be, or not those of the fit.
    """
    flat = [s for group in groups for s in group]
    check_test(flat)
    _require_blocks(fit, flat)
    made = iter([_replayed(fit, i, s) for i, s in enumerate(flat)])
    regenerated = [[next(made) for _ in group] for group in groups]
    band = model.band_hz
    measured_frf = convert(impact_frf(_treated(groups, band), rig, band), "mobility")
    regenerated_frf = convert(impact_frf(_treated(regenerated, band), rig, band), "mobility")
    return _verification(measured_frf, regenerated_frf, model)


def _require_blocks(fit: Fit, signals: Sequence[Signals]) -> None:
    blocks = fit.problem.blocks
    if len(signals) != len(blocks):
        found = f"there are {len(signals)} records, and the fit is of {len(blocks)} blocks"
        raise DataError(found, remedy="give the records that the model was identified from, in their order")
    for s, block in zip(signals, blocks, strict=True):
        grid, fitted = block.excitation.grid, len(block.response)
        if (len(s.responses), s.force.size, 1 / s.rate_hz) != (fitted, grid.n, grid.dt):
            found = f"{len(s.responses)} outputs of {s.force.size} samples {1 / s.rate_hz:g} s apart"
            raise DataError(
                f"{found}, and the fit is of {fitted} outputs of {grid.n} samples {grid.dt:g} s apart",
                where=f"record {s.block.name}",
                remedy="give the records that the model was identified from, in their order",
            )


def _replayed(fit: Fit, block: int, signals: Signals) -> Signals:
    """The block as the model would have answered the measured force."""
    excitation = fit.problem.blocks[block].excitation
    n, rate = signals.force.size, signals.rate_hz
    every = np.arange(1, (n + 1) // 2)
    if not isinstance(excitation, HitExcitation | ToneExcitation):
        raise DataError("the fit is of FRFs: it has no time records", remedy="compare it with FRFs by verify_frf")
    grid = replace(excitation.grid, omega=2 * np.pi * every * rate / n)
    if isinstance(excitation, ToneExcitation):
        whole = tone(grid, excitation.frequency_hz, excitation.amplitude, excitation.settled)
    else:
        whole = replace(excitation, grid=grid)
    spectrum = np.zeros((signals.responses.shape[0], n // 2 + 1), complex)
    spectrum[:, every] = fit.regenerated(block, whole)
    return replace(signals, responses=np.fft.irfft(spectrum, n))


def _treated(groups: Sequence[Sequence[Signals]], band: tuple[float, float]) -> list[list[Signals]]:
    """Mean removed and band-passed, force and responses alike: step A."""
    return [[replace(s, responses=_filtered(s.responses, s.rate_hz, band)) for s in group] for group in groups]


def _filtered(values: NDArray[np.float64], rate_hz: float, band: tuple[float, float]) -> NDArray[np.float64]:
    return bandpass(remove_mean(values), rate_hz, band)


def verify_sine(model: ModalModel, fit: Fit, signals: Sequence[Signals], rig: Rig) -> Verification:
    """Both sides by the same sine fit of the same block, the decay in it included.

    Args:
        model: the identified model.
        fit: the fit it came from.
        signals: the blocks of the test; those outside the model's band are left out, as the fit left them out.
        rig: channels and points.

    Raises:
        DataError: records that cannot be, or not those of the fit.
    """
    check_test(signals)
    low, high = model.band_hz
    chosen = [s for s in signals if low <= s.tone.frequency_hz <= high]
    _require_blocks(fit, chosen)
    regenerated = [_replayed(fit, i, s) for i, s in enumerate(chosen)]
    measured_frf = convert(stepped_frf(chosen, rig), "mobility")
    regenerated_frf = convert(stepped_frf(regenerated, rig), "mobility")
    return _verification(measured_frf, regenerated_frf, model)


def verify_frf(model: ModalModel, frf: Frf) -> Verification:
    """FRFs that came as such, against the model at their lines.

    Raises:
        DataError: no FRF.
    """
    frf = convert(frf, frf.quantity)
    inside = (frf.frequency_hz >= model.band_hz[0]) & (frf.frequency_hz <= model.band_hz[1])
    used = replace(
        frf, frequency_hz=frf.frequency_hz[inside], values=frf.values[..., inside], coherence=None, variance=None
    )
    measured = convert(used, "mobility")
    return _verification(measured, synthesised(model, measured.frequency_hz, "mobility"), model)


def synthesised(model: ModalModel, frequency_hz: NDArray[np.float64], quantity: FrfQuantity) -> Frf:
    """The model's own FRF, no block, no truncation."""
    plain = Frf(
        frequency_hz=frequency_hz,
        values=receptance(model, frequency_hz),
        quantity="receptance",
        outputs=model.outputs,
        output_points=model.output_points,
        input_points=model.input_points,
    )
    return convert(plain, quantity)


def frac(measured: NDArray[np.complex128], model: NDArray[np.complex128]) -> NDArray[np.float64]:
    """FRAC of two FRFs over their last axis: |H^H G|^2 / (H^H H G^H G), 1 where they agree up to a factor, else less.

    Source: Heylen, Lammens, "FRAC: a consistent way of comparing frequency response functions", IDENT'96 (1996).

    Args:
        measured: (..., lines).
        model: (..., lines).

    Raises:
        DataError: shapes that differ, no lines, or NaN.
    """
    if measured.shape != model.shape or measured.ndim < 1 or measured.shape[-1] == 0:
        raise DataError(
            f"FRFs of shapes {measured.shape} and {model.shape} cannot be compared",
            remedy="give both at the same lines",
        )
    if not (np.isfinite(measured).all() and np.isfinite(model).all()):
        raise DataError("an FRF holds NaN or infinite values", remedy="leave its lines out of the comparison")
    cross = np.abs(np.sum(measured.conj() * model, axis=-1)) ** 2
    power = np.sum(np.abs(measured) ** 2, axis=-1) * np.sum(np.abs(model) ** 2, axis=-1)
    return np.divide(cross, power, out=np.zeros_like(cross), where=power > 0)


def _verification(measured: Frf, regenerated: Frf, model: ModalModel) -> Verification:
    fine = np.geomspace(measured.frequency_hz[0], measured.frequency_hz[-1], FINE_LINES)
    # The peaks of light modes are narrower than any even grid: their own lines are added.
    fine = np.unique(
        np.concatenate(
            [
                fine,
                *[f * (1 + model.damping_ratio[r] * np.linspace(-4, 4, 33)) for r, f in enumerate(model.frequency_hz)],
            ]
        )
    )
    fine = fine[(fine >= measured.frequency_hz[0]) & (fine <= measured.frequency_hz[-1])]
    return Verification(
        measured=measured,
        regenerated=regenerated,
        untruncated=synthesised(model, fine, "mobility"),
        frac=frac(measured.values, regenerated.values),
    )
