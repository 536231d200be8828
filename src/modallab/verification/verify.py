"""Measured against regenerated mobility: the paper's figures 7 and 8."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128
from modallab.core.errors import DataError
from modallab.core.frf import DERIVATIVES, Frf, FrfQuantity
from modallab.core.model import ModalModel, Verification
from modallab.core.rig import Rig
from modallab.frf.estimate import convert_frf, impact_frf, output_quantity
from modallab.frf.stepped import stepped_frf
from modallab.identification.likelihood.basis import poles_of
from modallab.identification.likelihood.excitation import BlockLines, Excitation, HitExcitation
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.hit_blocks import moves_before
from modallab.identification.likelihood.orthonormal import real_rows
from modallab.identification.likelihood.sine_block import tone_excitation
from modallab.identification.model.modal_model import receptance_of_model
from modallab.signals.block_sets import check_test
from modallab.signals.signals import Signals


def replayed_hit(model: ModalModel, column: int, signals: Signals, quantity: FrfQuantity, *, moving: bool) -> Signals:
    """A hit's block with the model's responses.

    Args:
        model: the modes.
        column: the input that was struck.
        signals: the block.
        quantity: what the outputs measure.
        moving: whether the structure may have moved before the hit.

    Raises:
        DataError: the record has other outputs than the model, or no hit.
    """
    excitation = HitExcitation(_lines_of_block(signals, quantity), signals.hit_force, 0, signals.hit.first)
    return _replay_block(model, column, signals, excitation, moving=moving)


def replayed_sine(model: ModalModel, signals: Signals, quantity: FrfQuantity) -> Signals:
    """A sine block with the model's responses, the decay of what came before included.

    Raises:
        DataError: the record has other outputs than the model, or no sine.
    """
    found = signals.tone
    excitation = tone_excitation(_lines_of_block(signals, quantity), found.frequency_hz, complex(found.amplitude[0]), 0)
    return _replay_block(model, 0, signals, excitation, moving=True)


def _lines_of_block(signals: Signals, quantity: FrfQuantity) -> BlockLines:
    """Every line of the block but those at 0 Hz and at half the rate."""
    n, rate = signals.force.size, signals.rate_hz
    return BlockLines(2 * np.pi * np.arange(1, (n + 1) // 2) * rate / n, n, 1 / rate, DERIVATIVES[quantity])


def _replay_block(model: ModalModel, column: int, signals: Signals, excitation: Excitation, *, moving: bool) -> Signals:
    if signals.outputs != model.outputs:
        raise DataError(
            f"the record has outputs {list(signals.outputs)}, and the model {list(model.outputs)}",
            where=f"record {signals.block.name}",
            remedy="give the records that the model was identified from",
        )
    grid, n = excitation.grid, signals.force.size
    inside = _lines_inside(model, grid)
    answer = _forced_response(model, column, excitation, inside)
    if moving:
        left = np.fft.rfft(signals.responses)[:, 1 : grid.omega.size + 1] - answer
        answer += _motion_before(model, column, excitation, left, inside)
    spectrum = np.zeros((len(signals.responses), n // 2 + 1), complex)
    spectrum[:, 1 : grid.omega.size + 1] = answer
    return replace(signals, responses=np.fft.irfft(spectrum, n))


def _lines_inside(model: ModalModel, grid: BlockLines) -> NDArray[np.bool_]:
    frequency, slack = grid.omega / (2 * np.pi), 0.5 / (grid.n * grid.dt)
    return (frequency > model.band_hz[0] - slack) & (frequency < model.band_hz[1] + slack)


def _poles_and_residues(model: ModalModel, column: int) -> tuple[Complex128, Complex128]:
    """Poles (modes,) and residues (modes, outputs)."""
    poles = poles_of(2 * np.pi * model.frequency_hz, model.damping_ratio)
    return poles, np.asarray(model.modal_constants[:, :, column] / (2j * poles.imag[:, None]), np.complex128)


def _forced_response(model: ModalModel, column: int, excitation: Excitation, inside: NDArray[np.bool_]) -> Complex128:
    poles, residue = _poles_and_residues(model, column)
    answer = residue.T @ excitation.forced(poles)[0] + residue.conj().T @ excitation.forced(poles.conj())[0]
    # Outside the band a power of s says nothing of the structure, and grows without bound.
    for power, term in zip(model.residual_powers, model.residuals, strict=True):
        answer += np.where(inside, term[:, column, None] * excitation.static(power), 0)
    return np.asarray(answer, np.complex128)


def _motion_before(
    model: ModalModel, column: int, excitation: Excitation, left: Complex128, inside: NDArray[np.bool_]
) -> Complex128:
    """The free decays (outputs, lines) of the states that explain best what the forced answer leaves."""
    poles, residue = _poles_and_residues(model, column)
    up = residue[:, :, None] * excitation.free(poles)[0][:, None]
    down = residue.conj()[:, :, None] * excitation.free(poles.conj())[0][:, None]
    decays = np.concatenate([up + down, 1j * (up - down)])
    rows = real_rows(decays[..., inside].reshape(len(decays), -1))
    scale = np.maximum(np.linalg.norm(rows, axis=0), np.finfo(float).tiny)
    states = np.linalg.lstsq(rows / scale, real_rows(left[:, inside].reshape(1, -1))[:, 0], rcond=None)[0] / scale
    return np.asarray(np.tensordot(states, decays, 1), np.complex128)


FINE_LINES = 2000


def verify_impact(model: ModalModel, fit: LikelihoodFit, groups: Sequence[Sequence[Signals]], rig: Rig) -> Verification:
    """H1 of the blocks, and of the model's own answers to the measured forces, cut as the blocks were.

    Lines are chosen, nothing is filtered: at the lines of its DFT a block is what the model says it is, whatever lies
    outside the band.

    Args:
        model: the identified model: what is written of it is what is compared with the records.
        fit: the fit it came from, which says which records are its own.
        groups: the hits by point, in the order of the model's inputs.
        rig: channels and points.

    Raises:
        DataError: records that cannot be, or not those of the model.
    """
    flat = [s for group in groups for s in group]
    check_test(flat)
    _require_blocks(fit, flat)
    moving = any(moves_before(s) for s in flat)
    regenerated = [
        [replayed_hit(model, k, s, output_quantity(rig), moving=moving) for s in group]
        for k, group in enumerate(groups)
    ]
    measured = convert_frf(impact_frf(groups, rig, model.band_hz), "mobility")
    return _verification_of(measured, convert_frf(impact_frf(regenerated, rig, model.band_hz), "mobility"), model)


def _require_blocks(fit: LikelihoodFit, signals: Sequence[Signals]) -> None:
    blocks = fit.problem.blocks
    if len(signals) != len(blocks):
        found = f"there are {len(signals)} records, and the fit is of {len(blocks)} blocks"
        raise DataError(found, remedy="give the records that the model was identified from, in their order")
    for s, block in zip(signals, blocks, strict=True):
        grid, fitted = block.excitation.grid, len(block.response)
        if grid.n == 0:
            raise DataError("the fit is of FRFs: it has no time records", remedy="compare it with FRFs by verify_frf")
        if (len(s.responses), s.force.size, 1 / s.rate_hz) != (fitted, grid.n, grid.dt):
            found = f"{len(s.responses)} outputs of {s.force.size} samples {1 / s.rate_hz:g} s apart"
            raise DataError(
                f"{found}, and the fit is of {fitted} outputs of {grid.n} samples {grid.dt:g} s apart",
                where=f"record {s.block.name}",
                remedy="give the records that the model was identified from, in their order",
            )


def verify_sine(model: ModalModel, fit: LikelihoodFit, signals: Sequence[Signals], rig: Rig) -> Verification:
    """Both sides by the same sine fit of the same block, the decay in it included.

    Args:
        model: the identified model.
        fit: the fit it came from, which says which records are its own.
        signals: the blocks of the test; those outside the model's band are left out, as the fit left them out.
        rig: channels and points.

    Raises:
        DataError: records that cannot be, or not those of the model.
    """
    check_test(signals)
    low, high = model.band_hz
    chosen = [s for s in signals if low <= s.tone.frequency_hz <= high]
    _require_blocks(fit, chosen)
    regenerated = [replayed_sine(model, s, output_quantity(rig)) for s in chosen]
    measured = convert_frf(stepped_frf(chosen, rig), "mobility")
    return _verification_of(measured, convert_frf(stepped_frf(regenerated, rig), "mobility"), model)


def verify_frf(model: ModalModel, frf: Frf) -> Verification:
    """FRFs that came as such, against the model at their lines.

    FRAC is that of the quantity they were measured in: integrated, drift near 0 Hz would be most of it.

    Raises:
        DataError: no FRF.
    """
    frf = convert_frf(frf, frf.quantity)
    inside = (frf.frequency_hz >= model.band_hz[0]) & (frf.frequency_hz <= model.band_hz[1])
    used = replace(
        frf, frequency_hz=frf.frequency_hz[inside], values=frf.values[..., inside], coherence=None, variance=None
    )
    again = synthesised_frf(model, used.frequency_hz, used.quantity, used.damping_shift)
    compared = _verification_of(convert_frf(used, "mobility"), convert_frf(again, "mobility"), model)
    return replace(compared, frac=frac(used.values, again.values))


def synthesised_frf(
    model: ModalModel, frequency_hz: NDArray[np.float64], quantity: FrfQuantity, damping_shift: float = 0.0
) -> Frf:
    """The model's own FRF, no block, no truncation; with a damping shift as an exponential window leaves it."""
    plain = Frf(
        frequency_hz=frequency_hz,
        values=receptance_of_model(model, frequency_hz, damping_shift),
        quantity="receptance",
        outputs=model.outputs,
        output_points=model.output_points,
        input_points=model.input_points,
        damping_shift=damping_shift,
    )
    return convert_frf(plain, quantity)


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


def _verification_of(measured: Frf, regenerated: Frf, model: ModalModel) -> Verification:
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
        untruncated=synthesised_frf(model, fine, "mobility"),
        frac=frac(measured.values, regenerated.values),
    )
