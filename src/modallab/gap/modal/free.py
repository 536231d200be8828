"""What differs between any two tests of one structure, as free numbers in deviations of the rig's tolerances.

Stiffness and mass of the whole, how they are spread (a symmetric matrix in modal coordinates), damping of each mode,
sensitivities, the force of each driven point, where sensors and hits really are, and what cables add at each sensor.
"""

from dataclasses import dataclass
from math import log
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.rig import FORCE_SHARE
from modallab.gap.modal.compared import Compared
from modallab.gap.modal.state import Hung, State

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]


@dataclass(frozen=True, eq=False, slots=True)
class Change:
    """What may have been changed beyond all tolerances.

    Attributes:
        hung: on the structure.
        gains: output -> factor on what it reads.
        force_gain: factor on what the force channel reads.
        shifts: output -> metres along the two tangents.
    """

    hung: Hung | None = None
    gains: tuple[tuple[int, float], ...] = ()
    force_gain: float = 1.0
    shifts: tuple[tuple[int, float, float], ...] = ()


NOTHING = Change()


@dataclass(frozen=True, eq=False, slots=True)
class Free:
    """The free numbers of a comparison, in units of their deviations.

    Attributes:
        of: what is compared.
        loose: factor on by how much FRFs may be off. While a model is wrong the tolerances must not be bent to it.
    """

    of: Compared
    loose: float = 1.0

    @property
    def modes(self) -> int:
        """How many there are."""
        return self.of.model.n_modes

    @property
    def sizes(self) -> tuple[int, ...]:
        """How many numbers of each part: stiffness, mass, field, damping, gains, force, hit gains, places, masses."""
        outputs, inputs = len(self.of.out_psi), len(self.of.into_psi)
        return (
            1,
            1,
            self.modes * (self.modes + 1) // 2,
            self.modes,
            outputs,
            1,
            inputs,
            2 * outputs,
            2 * inputs,
            outputs,
        )

    @property
    def deviations(self) -> Real:
        """(numbers,) what one unit of each stands for; 0 for what is not free."""
        t = self.of.rig.tolerance
        each = (
            np.hypot(t.youngs_modulus, 3 * t.thickness),
            np.hypot(t.density, t.thickness),
            np.hypot(t.stiffness_field, t.mass_field),
            log(self.of.rig.damping_ratio.factor),
            t.sensitivity,
            FORCE_SHARE * t.sensitivity,
            t.hit_gain,
            t.position_m,
            t.hit_position_m,
            t.sensor_mass_kg,
        )
        return np.concatenate([np.full(n, value) for n, value in zip(self.sizes, each, strict=True)])

    @property
    def size(self) -> int:
        """How many numbers."""
        return sum(self.sizes)

    def parts(self, u: Real) -> list[Real]:
        """The numbers by part, in their own units."""
        return np.split(u * self.deviations, np.cumsum(self.sizes)[:-1])

    def state(self, u: Real, change: Change = NOTHING) -> State:
        """All numbers of the prediction."""
        kappa, mu, field, zeta, gains, force, hits, at, struck, masses = self.parts(u)
        c = self.of
        gain = np.exp(gains)
        for o, factor in change.gains:
            gain[o] *= factor
        moved = c.out_psi + np.einsum("oj,ojm->om", at.reshape(-1, 2), c.out_slopes)
        for o, first, second in change.shifts:
            moved[o] += np.array([first, second]) @ c.out_slopes[o]
        into = c.into_psi + np.einsum("ij,ijm->im", struck.reshape(-1, 2), c.into_slopes)
        applied = np.exp(hits - force[0]) / change.force_gain
        upper = np.triu_indices(self.modes)
        e = np.zeros((self.modes, self.modes))
        e[upper] = field
        return State(
            omega=2 * np.pi * c.model.frequency_hz,
            zeta=c.model.damping_ratio * np.exp(zeta),
            out=moved,
            into=into,
            gain=gain,
            applied=applied,
            stiffness=float(np.exp(kappa[0])),
            mass=float(np.exp(mu[0])),
            field=e + np.triu(e, 1).T,
            sensor_masses=masses,
            sensor_shapes=c.out_psi,
            hung=change.hung,
        )

    def residual(self, u: Real, change: Change = NOTHING, lines: slice = slice(None)) -> Real:
        """(2 lines outputs inputs,) predicted less measured, in deviations."""
        c = self.of
        predicted = self.state(u, change).receptance(c.s[lines], c.outside[lines])
        return _real((predicted - c.measured[lines]) / (self.loose * c.sigma[lines]))

    def slopes(self, u: Real, change: Change = NOTHING, lines: slice = slice(None)) -> Real:
        """(2 lines outputs inputs, numbers) derivatives of `residual`."""
        c, state = self.of, self.state(u, change)
        s, one = c.s[lines], self.deviations
        found = _derivatives(self, state, s, c.outside[lines])
        weighed = [_real(d / (self.loose * c.sigma[lines])) for d in found]
        return np.stack(weighed, axis=1) * one


def _real(values: Complex) -> Real:
    flat = values.ravel()
    return np.concatenate([flat.real, flat.imag]).astype(np.float64)


def _derivatives(free: Free, state: State, s: Complex, outside: Complex) -> list[Complex]:
    """By each number in its own unit, (lines, outputs, inputs) each, in the order of `Free.sizes`."""
    flexibility = state.flexibility(s)
    rows, columns = state.local(s)
    rows, columns = rows * state.gain, columns * state.applied
    x = rows[:, :, None] * (state.out @ flexibility)
    y = (flexibility @ state.into.T) * columns[:, None, :]
    whole = state.receptance(s, outside)
    omega, c = state.omega, free.of
    pairs = [(int(r), int(q)) for r, q in zip(*np.triu_indices(free.modes), strict=True)]

    def through(r: int, q: int) -> Complex:
        return x[:, :, r, None] * y[:, None, q, :]

    found = [-state.stiffness * (x * omega**2 @ y)]
    found.append(-state.mass * s[:, None, None] ** 2 * (x @ y))
    found += [-omega[r] * omega[q] * (through(r, q) + through(q, r) if r != q else through(r, r)) for r, q in pairs]
    found += [-2 * state.zeta[r] * omega[r] * s[:, None, None] * through(r, r) for r in range(free.modes)]
    found += [_only(whole, 1, o) for o in range(len(state.out))]
    found.append(-whole)
    found += [_only(whole, 2, i) for i in range(len(state.into))]
    for o in range(len(state.out)):
        for j in range(2):
            found.append(_row(rows[:, o, None] * (c.out_slopes[o, j] @ y), o, whole))
    for i in range(len(state.into)):
        for j in range(2):
            part = columns[:, i, None] * (x @ c.into_slopes[i, j])
            found.append(_column(part, i, whole))
    at = x @ state.sensor_shapes.T, state.sensor_shapes @ y
    found += [
        -(s[:, None, None] ** 2) * at[0][:, :, p, None] * at[1][:, None, p, :] for p in range(len(state.sensor_masses))
    ]
    return found


def _only(whole: Complex, axis: int, place: int) -> Complex:
    kept = np.zeros_like(whole)
    index = (slice(None),) * axis + (place,)
    kept[index] = whole[index]
    return kept


def _row(values: Complex, o: int, whole: Complex) -> Complex:
    kept = np.zeros_like(whole)
    kept[:, o, :] = values
    return kept


def _column(values: Complex, i: int, whole: Complex) -> Complex:
    kept = np.zeros_like(whole)
    kept[:, :, i] = values
    return kept
