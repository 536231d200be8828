"""A block as a written model would have answered its measured force: poles, modal constants and residual terms alone.

What the model cannot know is the motion that was there before the block: one state for each mode, which follows from
the record by least squares.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128
from modallab.core.errors import DataError
from modallab.core.frf import DERIVATIVES, FrfQuantity
from modallab.core.model import ModalModel
from modallab.identification.likelihood.basis import poles_of
from modallab.identification.likelihood.excitation import BlockLines, Excitation, HitExcitation
from modallab.identification.likelihood.orthonormal import real_rows
from modallab.identification.likelihood.sine_block import tone_excitation
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
