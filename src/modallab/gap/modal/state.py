"""The bench as a modal model with what may have changed, and the FRFs it predicts.

In modal coordinates, at unit modal mass of the reference, the dynamic stiffness is
D = s^2 (mu I + sum m psi psi^T) + 2 sqrt(kappa mu) zeta omega s + Omega (kappa I + E) Omega, and
H = Phi_out D^-1 Phi_in^T + R, where R is all that the reference's FRFs hold besides, so that they are the reference's
exactly where nothing is free. E is a symmetric matrix: how stiffness (and mass) of the bench differ from those of the
reference from place to place.
What hangs at freedoms f, of dynamic stiffness z, changes H to H - H_of z (I + z H_ff)^-1 H_fi (receptance coupling:
Ewins, Modal Testing, 2nd ed. 2000, section 6.3). Where f was driven and a sensor stood there, all four are measured.
"""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex, Real


def filtered(s: Complex, filters: Real) -> Complex:
    """(lines, outputs) what filters (outputs, powers) make of each line: exp(f_1 s + f_2 s^2 + ...)."""
    powers = s[:, None] ** np.arange(1, filters.shape[1] + 1)
    return np.asarray(np.exp(powers @ filters.T), np.complex128)


@dataclass(frozen=True, eq=False, slots=True)
class AttachedElement:
    """What hangs on the structure at a place.

    Attributes:
        seen: (directions, modes) shapes there as sensors show them; those after the outputs are of its damping, which
            is s times its stiffness.
        driven: (directions, modes) as forces there excite them.
        mass_kg: of it.
        stiffness: to ground, N/m.
        damping: to ground, N s/m.
        outputs: of each direction the output that stands there, or None.
        inputs: of each direction the input there, or None.
        compliance: of the modes outside the band at this place where it was not measured, m/N.
        near: share of what lies outside the band that counts: 1 at the very place, 0 far from it.
        turn: phase of the chain, exp(j phase), that measured FRFs have and what hangs there has not.
        opposed: whether it hangs between its two directions instead of on each.
        extra: (lines, outputs, inputs) m/N that FRFs coupled line by line have over what is coupled off the axis; None
            where they were not measured.
    """

    seen: Complex
    driven: Complex
    mass_kg: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    outputs: tuple[int | None, ...] = ()
    inputs: tuple[int | None, ...] = ()
    compliance: float = 0.0
    near: float = 1.0
    turn: complex = 1.0
    opposed: bool = False
    extra: Complex | None = None

    def dynamic_stiffness(self, s: Complex) -> Complex:
        """(lines,) of what hangs there, N/m."""
        return np.asarray(self.mass_kg * s**2 + self.damping * s + self.stiffness)

    def forces(self, s: Complex) -> Complex:
        """(lines, directions, directions) by which motions give forces, N/m."""
        d = len(self.outputs)
        pattern = np.array([[1.0, -1.0], [-1.0, 1.0]]) if self.opposed else np.eye(d)
        found = np.zeros((s.size, len(self.seen), len(self.seen)), np.complex128)
        found[:, :d, :d] = self.dynamic_stiffness(s)[:, None, None] * pattern
        if len(self.seen) > d:
            found[:, d:, d:] = (self.stiffness * s)[:, None, None] * pattern
        return found

    def beside_modes(self, outside: Complex) -> tuple[Complex, Complex, Complex]:
        """What lies outside the band: to the outputs, from the inputs, and at the place itself.

        Args:
            outside: (lines, outputs, inputs) of the reference.

        Returns:
            (lines, outputs, directions), (lines, directions, inputs) and (lines, directions, directions), m/N.
        """
        lines, n_out, n_in = outside.shape
        d = len(self.seen)
        to: Complex = np.zeros((lines, n_out, d), np.complex128)
        of: Complex = np.zeros((lines, d, n_in), np.complex128)
        here: Complex = np.zeros((lines, d, d), np.complex128)
        for k, (o, i) in enumerate(zip(self.outputs, self.inputs, strict=True)):
            here[:, k, k] = self.compliance if o is None or i is None else outside[:, o, i] / self.turn
            if i is not None:
                to[:, :, k] = outside[:, :, i] / self.turn
                of[:, k, i] = self.compliance * self.turn
            elif o is not None:
                to[:, o, k] = self.compliance
            if o is not None:
                of[:, k] = outside[:, o]
        return self.near * to, self.near * of, self.near * here

    def coupled(self, frfs: Complex, s: Complex) -> Complex:
        """(lines, outputs, inputs) receptances of a structure with it, where one sensor stands at one driven point."""
        (o,), (i,) = self.outputs, self.inputs
        assert o is not None
        assert i is not None
        z = self.dynamic_stiffness(s) / self.turn
        through = z / (1 + z * frfs[:, o, i])
        return np.asarray(frfs - frfs[:, :, [i]] * through[:, None, None] * frfs[:, [o]])


@dataclass(frozen=True, eq=False, slots=True)
class Structure:
    """What of a prediction no change has a part in.

    Attributes:
        omega: (modes,) rad/s of the reference.
        zeta: (modes,) damping ratios.
        stiffness: kappa.
        mass: mu.
        field: (modes, modes) E, symmetric.
        across: (modes, modes) symmetric, 0 on the diagonal: damping between modes over that of the two.
        sensor_masses: (sensors,) kg beyond those of the reference.
        sensor_shapes: (sensors, modes) where they sit.
    """

    omega: Real
    zeta: Real
    stiffness: float
    mass: float
    field: Real
    across: Real
    sensor_masses: Real
    sensor_shapes: Complex

    def flexibility(self, s: Complex) -> Complex:
        """(lines, modes, modes) D^-1, without what hangs there."""
        n = self.omega.size
        attached = (self.sensor_shapes.T * self.sensor_masses) @ self.sensor_shapes
        inertia = self.mass * np.eye(n) + attached
        elastic = np.outer(self.omega, self.omega) * (self.stiffness * np.eye(n) + self.field)
        d = s[:, None, None] ** 2 * inertia + elastic
        # Damping ratios of a structure that is stiffer or heavier as a whole stay what they are.
        scale = np.sqrt(self.stiffness * self.mass)
        d[:, range(n), range(n)] += s[:, None] * (2 * scale * self.zeta * self.omega)
        d += s[:, None, None] * (2 * self.across * np.sqrt(np.outer(self.zeta * self.omega, self.zeta * self.omega)))
        return np.linalg.inv(d)


@dataclass(frozen=True, eq=False, slots=True)
class State:
    """All numbers of a prediction.

    Attributes:
        structure: without what may have been changed.
        flexibility: (lines, modes, modes) of it.
        out: (outputs, modes) shapes at the outputs.
        into: (inputs, modes) shapes at the inputs.
        gain: (outputs,) factors on what the outputs read.
        filters: (outputs, powers) coefficients of the logarithm of what they read over that, by s, s^2 and so on.
        mixed: (outputs, outputs) of what lies beside the shapes: a sensor that moved shows that of its new place.
        direct: (lines, outputs) of the force itself that an output shows, m/N.
        applied: (inputs,) force that acts over the force that is read.
        hung: the change that is looked for.
    """

    structure: Structure
    flexibility: Complex
    out: Complex
    into: Complex
    gain: Real
    filters: Real
    mixed: Real
    direct: Complex
    applied: Real
    hung: AttachedElement | None = None

    def paths(self, s: Complex, outside: Complex) -> tuple[Complex, Complex, Complex]:
        """How modal forces come to the outputs and forces at the inputs to the modes, with what hangs there; and H.

        Returns:
            (lines, outputs, modes), (lines, modes, inputs) and (lines, outputs, inputs), without any gain.
        """
        flexibility = self.flexibility
        x, y = self.out @ flexibility, flexibility @ self.into.T
        outside = np.asarray(self.mixed @ outside + self.direct[:, :, None])
        whole = x @ self.into.T + outside
        if self.hung is None:
            return x, y, whole
        hung = self.hung
        to, of, here = hung.beside_modes(outside)
        z = hung.forces(s)
        seen = hung.seen @ flexibility
        to, of = x @ hung.driven.T + to, seen @ self.into.T + of
        through = np.linalg.solve(np.eye(len(hung.seen)) + z @ (seen @ hung.driven.T + here), z)
        x_changed = x - to @ through @ seen
        y_changed = y - (flexibility @ hung.driven.T) @ through @ of
        changed = whole - to @ through @ of
        return x_changed, y_changed, changed if hung.extra is None else changed + hung.extra

    def read(self, s: Complex) -> Complex:
        """(lines, outputs) what the outputs read over what they should."""
        return np.asarray(self.gain * filtered(s, self.filters), np.complex128)

    def receptance(self, s: Complex, outside: Complex) -> Complex:
        """(lines, outputs, inputs), with the reference's part `outside` the band, (lines, outputs, inputs)."""
        return np.asarray(self.read(s)[:, :, None] * self.paths(s, outside)[2] * self.applied, np.complex128)
