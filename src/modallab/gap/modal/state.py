"""The bench as a modal model with what may have changed, and the FRFs it predicts.

In modal coordinates, at unit modal mass of the reference, the dynamic stiffness is
D = s^2 (mu I + sum m psi psi^T) + 2 zeta omega s + Omega (kappa I + E) Omega + sum z psi psi^T,
and H = Phi_out D^-1 Phi_in^T + R. E is a symmetric matrix: how stiffness (and mass) of the bench differ from those of
the reference from place to place. What hangs on a point, of dynamic stiffness z, feels the modes outside the band as a
local compliance r in series: z / (1 + z r), and what moves or is driven at that very point is moved by 1 / (1 + z r)
(structural modification by the receptance method: Ewins, Modal Testing, 2nd ed. 2000, section 6.3).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]


@dataclass(frozen=True, eq=False, slots=True)
class Hung:
    """What hangs on the structure at a place.

    Attributes:
        psi: (directions, modes) shapes there.
        mass_kg: of it.
        stiffness: to ground, N/m.
        compliance: of the modes outside the band at this place, m/N.
        outputs: numbers of the outputs at this freedom.
        inputs: numbers of the inputs there.
        near: share of that compliance which outputs and inputs there feel: 1 at the very place, 0 far from it.
    """

    psi: Real
    mass_kg: float = 0.0
    stiffness: float = 0.0
    compliance: float = 0.0
    outputs: tuple[int, ...] = ()
    inputs: tuple[int, ...] = ()
    near: float = 1.0

    def dynamic_stiffness(self, s: Complex) -> Complex:
        """(lines,) of what hangs there, N/m."""
        return np.asarray(self.mass_kg * s**2 + self.stiffness)


@dataclass(frozen=True, eq=False, slots=True)
class State:
    """All numbers of a prediction.

    Attributes:
        omega: (modes,) rad/s of the reference.
        zeta: (modes,) damping ratios.
        out: (outputs, modes) shapes at the outputs.
        into: (inputs, modes) shapes at the inputs.
        gain: (outputs,) factors on what the outputs read.
        applied: (inputs,) force that acts over the force that is read.
        stiffness: kappa.
        mass: mu.
        field: (modes, modes) E, symmetric.
        across: (modes, modes) symmetric, 0 on the diagonal: damping between modes over that of the two.
        sensor_masses: (sensors,) kg beyond those of the reference.
        sensor_shapes: (sensors, modes) where they sit.
        hung: the change that is looked for.
    """

    omega: Real
    zeta: Real
    out: Real
    into: Real
    gain: Real
    applied: Real
    stiffness: float
    mass: float
    field: Real
    across: Real
    sensor_masses: Real
    sensor_shapes: Real
    hung: Hung | None = None

    def flexibility(self, s: Complex) -> Complex:
        """(lines, modes, modes) D^-1."""
        n = self.omega.size
        attached = (self.sensor_shapes.T * self.sensor_masses) @ self.sensor_shapes
        inertia = self.mass * np.eye(n) + attached
        elastic = np.outer(self.omega, self.omega) * (self.stiffness * np.eye(n) + self.field)
        d = s[:, None, None] ** 2 * inertia + elastic
        d[:, range(n), range(n)] += s[:, None] * (2 * self.zeta * self.omega)
        d += s[:, None, None] * (2 * self.across * np.sqrt(np.outer(self.zeta * self.omega, self.zeta * self.omega)))
        if self.hung is not None:
            z = self.hung.dynamic_stiffness(s)
            d += (z / (1 + z * self.hung.compliance))[:, None, None] * (self.hung.psi.T @ self.hung.psi)
        return np.linalg.inv(d)

    def local(self, s: Complex) -> tuple[Complex, Complex]:
        """(lines, outputs) and (lines, inputs) by which the place itself moves, and is driven, less."""
        rows = np.ones((s.size, len(self.out)), dtype=np.complex128)
        columns = np.ones((s.size, len(self.into)), dtype=np.complex128)
        if self.hung is not None and self.hung.compliance:
            zr = self.hung.dynamic_stiffness(s) * self.hung.compliance
            less = 1 - self.hung.near * zr / (1 + zr)
            rows[:, list(self.hung.outputs)] = less[:, None]
            columns[:, list(self.hung.inputs)] = less[:, None]
        return rows, columns

    def receptance(self, s: Complex, outside: Complex) -> Complex:
        """(lines, outputs, inputs), with the reference's part `outside` the band, (lines, outputs, inputs)."""
        rows, columns = self.local(s)
        modal = self.out @ self.flexibility(s) @ self.into.T
        scaled = np.outer(self.gain, self.applied)
        return rows[:, :, None] * (modal + outside) * scaled * columns[:, None, :]
