"""The size of what hangs at a driven point, from the measured FRFs themselves.

Where a sensor stands at a driven point, what hangs there changes receptances H to H - H_of z H_fi / (1 + z H_ff), all
of it measured: no modal model need hold, and what a fit of modes leaves of the FRFs is left in both.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from modallab.core.frf import DERIVATIVES, Frf
from modallab.gap.modal.compared import Compared
from modallab.gap.modal.errors import ERROR, sizes
from modallab.gap.modal.free import Free
from modallab.gap.modal.search import Fitted
from modallab.gap.modal.state import Hung
from modallab.modification.synthesis import beside, synthesised

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]


@dataclass(frozen=True, eq=False, slots=True)
class CoupledPair:
    """Measured FRFs of the reference and of the bench on common lines.

    Attributes:
        s: (lines,) j omega.
        before: (lines, outputs, inputs) receptances of the reference.
        after: (lines, outputs, inputs) of the bench.
    """

    s: Complex
    before: Complex
    after: Complex


def pair_of(reference: Frf, bench: Frf, c: Compared) -> CoupledPair | None:
    """The FRFs of what is compared; None where they are not on the same lines, or lack an output or an input."""
    low, high = c.s.imag[[0, -1]] / (2 * np.pi)
    lines = np.intersect1d(reference.frequency_hz, bench.frequency_hz)
    lines = lines[(lines >= low) & (lines <= high) & (lines > 0)]
    before, after = (_receptance(frf, lines, c) for frf in (reference, bench))
    if before is None or after is None or lines.size < 2:
        return None
    return CoupledPair(np.asarray(2j * np.pi * lines), before, after)


def _receptance(frf: Frf, lines: Real, c: Compared) -> Complex | None:
    driven = (None,) if len(frf.input_points) == 1 and frf.input_points[0] is None else c.model.input_points
    if not set(c.model.outputs) <= set(frf.outputs) or not set(driven) <= set(frf.input_points) or frf.damping_shift:
        return None
    rows, columns = [frf.outputs.index(n) for n in c.model.outputs], [frf.input_points.index(p) for p in driven]
    values = frf.values[rows][:, columns][..., np.searchsorted(frf.frequency_hz, lines)]
    return np.asarray(np.moveaxis(values, -1, 0) / (2j * np.pi * lines[:, None, None]) ** DERIVATIVES[frf.quantity])


def unlike(pair: CoupledPair, c: Compared) -> Real:
    """(outputs, inputs) by how much the two models differ otherwise than the measured FRFs do, over these.

    What both models miss of the FRFs alike does not count; what an identification makes of the noise of one does.
    """
    rate = pair.s[:, None, None]
    by_models = synthesised(c.bench, pair.s) - synthesised(c.model, pair.s)
    left = rate * (by_models - (pair.after - pair.before))
    return np.asarray(np.hypot(ERROR, np.linalg.norm(left, axis=0) / np.linalg.norm(rate * pair.after, axis=0)))


def refined(free: Free, fitted: Fitted, pair: CoupledPair) -> Fitted:
    """The explanation with its size from measured FRFs, if these are explained better so than by the modal model.

    One that does not hang at a driven point where a sensor stands is given back as it is.
    """
    candidate, hung = fitted.candidate, fitted.change.hung
    if candidate is None or hung is None or len(hung.seen) > 1 or None in (*hung.outputs, *hung.inputs):
        return fitted
    weight = 1 / sizes(pair.after)

    def left(v: Real) -> Real:
        return _parts(weight * (_coupled(pair, _hung_there(fitted, v)) - pair.after))

    found = least_squares(left, np.array([fitted.v[0], 0.0]), x_scale=(0.1, 0.1))
    by_modes = _parts(weight * (_by_modes(free, fitted, pair) - pair.after))
    if float(np.sum(by_modes**2)) <= 2 * found.cost:
        return fitted
    return _with_size(fitted, found.x, np.asarray(found.jac, np.float64), 2 * found.cost / max(by_modes.size - 2, 1))


def _hung_there(fitted: Fitted, v: Real) -> Hung:
    """What hangs at the point itself, of a size and a phase (2,)."""
    candidate = fitted.candidate
    assert candidate is not None
    hung = candidate.make(np.array([v[0], 0.0, 0.0, 0.0, v[1]])).hung
    assert hung is not None
    return hung


def _coupled(pair: CoupledPair, hung: Hung) -> Complex:
    o, i = hung.outputs[0], hung.inputs[0]
    assert o is not None
    assert i is not None
    z = hung.dynamic_stiffness(pair.s) / hung.turn
    through = z / (1 + z * pair.before[:, o, i])
    return np.asarray(pair.before - pair.before[:, :, [i]] * through[:, None, None] * pair.before[:, [o]])


def _by_modes(free: Free, fitted: Fitted, pair: CoupledPair) -> Complex:
    """The measured FRFs of the reference, with what the modal model says that is changed."""
    c = free.of
    predicted = free.state(fitted.u, fitted.change).receptance(pair.s, beside(c.model, pair.s, c.out_psi, c.into_psi))
    return pair.before + predicted - synthesised(c.model, pair.s)


def _parts(values: Complex) -> Real:
    return np.asarray(np.concatenate([values.real.ravel(), values.imag.ravel()]), np.float64)


def _with_size(fitted: Fitted, v: Real, slopes: Real, power: float) -> Fitted:
    whole, n = fitted.v.copy(), fitted.u.size
    whole[0], whole[1:3], whole[4] = v[0], 0.0, v[1]
    covariance = fitted.covariance.copy()
    covariance[n] = covariance[:, n] = 0.0
    covariance[n, n] = power * np.linalg.inv(slopes.T @ slopes + 1e-12 * np.eye(2))[0, 0]
    return replace(fitted, v=whole, covariance=covariance, measured=True)
