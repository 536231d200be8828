"""By how much the FRFs of two modal models of one structure differ, though nothing was changed and no tolerance used.

Modes outside the band mix into every shape where stiffness and mass are spread a little otherwise: each modal constant
is off by itself. They are also what the residual terms stand for, short waves that a sensor or a hit which is off by
little moves by much. Both go along whole FRFs; what is left goes from line to line.
"""

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.model import ModalModel
from modallab.gap.modal.weights import Weights
from modallab.modification.frfs import receptance_of_modes

ERROR = 0.007
"""By how much of its size a line of an FRF is off for reasons that no free number stands for, one deviation."""
SMALL = 0.3
"""FRFs smaller than this share of the rms over all FRFs on a line are weighed as if they had it: nodes and dips."""
OUTSIDE = 0.3
"""By how much of its size each residual term of an FRF may be off."""
OPEN = 3.0
"""The same of a term that the reference's model does not have, and no FRFs say: it is not known at all."""
SHAPE = 0.015
"""By how much of its size a modal constant is off by itself: what modes outside the band mix into a shape."""


def sizes(measured: Complex) -> Real:
    """(lines, outputs, inputs) of FRFs, the small ones as if they were a share of their line's rms."""
    size = np.abs(measured)
    return np.hypot(size, SMALL * _rms(size))


def weights(
    reference: ModalModel,
    bench: ModalModel,
    s: Complex,
    measured: Complex,
    noise: Complex | None = None,
    lines: Real | float = 1.0,
    along: Real | float = 1.0,
) -> Weights:
    """Of misfits between the reference and FRFs `measured` (lines, outputs, inputs) of the bench.

    Args:
        reference: of the comparison.
        bench: of the comparison.
        s: (lines,) complex frequencies.
        measured: receptances of the bench there.
        noise: (lines, lines, outputs, inputs) covariance of what both are off by from noise, where it was measured.
        lines: factor on by how much each line is off by itself: (outputs, 1), (1, inputs) or all.
        along: the same of what goes along whole FRFs.
    """
    # What lies outside the band is in measured FRFs, whatever terms either model made of it.
    terms, of_terms = _of_residuals(reference, bench if noise is None else reference, s)
    constants = np.abs(bench.modal_constants)
    size = np.hypot(constants, SMALL * _rms(constants))
    # One that was not found at all is believed to be as large as it is.
    values_at_modes = np.hypot(SHAPE * size, np.minimum(np.nan_to_num(bench.modal_constant_sigma), size))
    # A modal constant is complex: it may be off in size and in phase.
    modes = receptance_of_modes(bench, s).T
    shapes = np.concatenate([terms, modes, 1j * modes])
    spread = np.concatenate([of_terms, values_at_modes, values_at_modes])
    return Weights.of(ERROR * lines * sizes(measured), shapes, along * spread, noise)


def _of_residuals(reference: ModalModel, bench: ModalModel, s: Complex) -> tuple[Complex, Real]:
    """(terms, lines) of each residual term, and (terms, outputs, inputs) by how much it may be off."""
    powers = sorted({*reference.residual_powers, *bench.residual_powers})
    middle = float(np.median(np.abs(s)))
    spread = np.zeros((len(powers), *bench.modal_constants.shape[1:]))
    for n, power in enumerate(powers):
        known = [m.residuals[m.residual_powers.index(power)] for m in (reference, bench) if power in m.residual_powers]
        size = np.sqrt(np.mean(np.square(known), axis=0))
        share = OUTSIDE if power in reference.residual_powers else OPEN
        spread[n] = share * np.hypot(size, SMALL * _rms(size)) * middle**power
    return np.array([(s / middle) ** power for power in powers]).reshape(len(powers), s.size), spread


def _rms(values: Real) -> Real:
    return np.sqrt(np.mean(values**2, axis=(-2, -1), keepdims=True))
