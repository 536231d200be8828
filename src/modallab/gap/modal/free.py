"""What differs between any two tests of one structure, as free numbers in deviations of the rig's tolerances.

Stiffness and mass of the whole, how they are spread (a symmetric matrix in modal coordinates), damping of each mode,
sensitivities, the force of each driven point, where sensors and hits really are, and what cables add at each sensor.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.rig import FORCE_SHARE
from modallab.gap.modal.beside_modes import BesideModes
from modallab.gap.modal.compared import Compared
from modallab.gap.modal.derivatives import derivatives
from modallab.gap.modal.floor import floor_of_structure
from modallab.gap.modal.state import AttachedElement, State, Structure, filtered

SCALES = 6
"""Scales that a number of the structure may have."""
UNKNOWN_FORCE = 10.0
"""Deviation of what a force that nobody measured does to a mode, over what it seems to do."""


@dataclass(frozen=True, eq=False, slots=True)
class Change:
    """What may have been changed beyond all tolerances.

    Attributes:
        hung: on the structure.
        gains: output -> factor on what it reads.
        force_gain: factor on what the force channel reads.
        hit_gains: input -> factor on the force that acts there.
        shifts: output -> metres along the two tangents, and by how many deviations the shapes there are off (modes,).
        filters: (outputs, powers) as of `State`; None where nothing is filtered.
        mixed: an output, its shares of what each of them reads (outputs,), and of the force, in its quantity over N.
    """

    hung: AttachedElement | None = None
    gains: tuple[tuple[int, float], ...] = ()
    force_gain: float = 1.0
    hit_gains: tuple[tuple[int, float], ...] = ()
    shifts: tuple[tuple[int, Real, Real], ...] = ()
    filters: Real | None = None
    mixed: tuple[int, Real, float] | None = None

    @property
    def between_lines(self) -> "Change":
        """The same on other lines than those compared: what was coupled line by line is not known there."""
        return self if self.hung is None else replace(self, hung=replace(self.hung, extra=None))


NOTHING = Change()


@dataclass(frozen=True, eq=False, slots=True)
class Free:
    """The free numbers of a comparison, in units of their deviations.

    Attributes:
        of: what is compared.
        loose: factor on by how much FRFs may be off. While a model is wrong the tolerances must not be bent to it.
        wide: factor on by how much the structure itself is another in two tests; one, or one of each of its numbers.
        deviations: (numbers,) what one unit of each stands for; 0 for what is not free.
        last: numbers that were asked for last -> the structure and its flexibility, which all changes share.
    """

    of: Compared
    loose: float = 1.0
    wide: Real | float = 1.0
    deviations: Real = field(init=False)
    last: dict[bytes, tuple[Structure, Complex]] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Compute the deviations once: every prediction needs them."""
        object.__setattr__(self, "deviations", self._deviations())

    @property
    def modes(self) -> int:
        """How many there are."""
        return self.of.model.n_modes

    @property
    def sizes(self) -> tuple[int, ...]:
        """How many of each: stiffness, mass, field, damping, gains, force, hits, places, masses, damping across."""
        outputs, inputs = len(self.of.response_factors), len(self.of.force_factors)
        return (
            1,
            1,
            self.modes * (self.modes + 1) // 2,
            self.modes,
            outputs,
            1,
            inputs,
            2 * outputs,
            inputs * self.of.force_slopes.shape[1],
            outputs,
            len(self.of.close_pairs),
        )

    def _deviations(self) -> Real:
        t = self.of.rig.tolerance
        tolerances, of_models = floor_of_structure(self.of.model, self.of.bench, self.of.rig)
        structure = np.hypot(self.wide * tolerances, of_models)
        damping = structure[-self.modes :]
        pairs = [(damping[r] + damping[q]) / 4 for r, q in self.of.close_pairs]
        each = (
            structure,
            t.sensitivity,
            FORCE_SHARE * t.sensitivity,
            t.hit_gain,
            t.position_m,
            UNKNOWN_FORCE if self.of.bench.operating_shapes is not None else t.hit_position_m,
            t.sensor_mass_kg,
            np.array(pairs),
        )
        sizes = structure.size, *self.sizes[4:]
        return np.concatenate([np.full(n, value) for n, value in zip(sizes, each, strict=True)])

    @property
    def price(self) -> float:
        """-2 ln of the prior odds that of all numbers of the structure just these have scales of their own."""
        wide = np.asarray(self.wide)
        return 2 * float(np.log(max(wide.size, 1) * SCALES)) * np.count_nonzero(wide > wide.min())

    @property
    def structure_size(self) -> int:
        """How many numbers are the structure's: stiffness, mass, field and damping."""
        return sum(self.sizes[:4])

    @property
    def size(self) -> int:
        """How many numbers."""
        return sum(self.sizes)

    def at(self, s: Complex, outside: Callable[[Complex], Complex]) -> "Free":
        """The same at other lines (lines,), given the reference's part `outside` its shapes, to predict alone."""
        return replace(self, of=replace(self.of, s=s, outside=BesideModes.of(outside, s)))

    def parts(self, u: Real) -> list[Real]:
        """The numbers by part, in their own units."""
        return np.split(u * self.deviations, np.cumsum(self.sizes)[:-1])

    def state(self, u: Real, change: Change = NOTHING) -> State:
        """All numbers of the prediction."""
        _, _, _, _, gains, force, hits, at, struck, _, _ = self.parts(u)
        c = self.of
        gain = np.exp(gains)
        for o, factor in change.gains:
            gain[o] *= factor
        moved = c.response_factors + np.einsum("oj,ojm->om", at.reshape(-1, 2), c.response_slopes)
        mixed = np.eye(len(gain))
        for o, along_m, off in change.shifts:
            moved[o] += c.shifted(o, along_m, off)
            mixed[o] += c.rows_of(o, along_m)
        direct = np.zeros((c.s.size, len(gain)), np.complex128)
        if change.mixed is not None:
            o, shares, of_force = change.mixed
            moved[o] += shares @ moved
            mixed[o] += shares
            direct[:, o] = of_force / c.s**c.power
        filters = np.zeros((len(gain), 1)) if change.filters is None else change.filters
        if c.noise is None:
            # Of a model alone: what an identification makes of a delay is a shape that is turned mode by mode.
            moved = moved * filtered(2j * np.pi * c.model.frequency_hz, filters).T
            filters = 0 * filters
        driven = c.force_factors + np.einsum("ij,ijm->im", struck.reshape(c.force_slopes.shape[:2]), c.force_slopes)
        applied = np.exp(hits - force[0]) / change.force_gain
        for i, factor in change.hit_gains:
            applied[i] *= factor
        structure, flexibility = self.structure(u)
        return State(
            structure=structure,
            flexibility=flexibility,
            out=moved,
            into=driven,
            gain=gain,
            filters=filters,
            mixed=mixed,
            direct=direct,
            applied=applied,
            hung=change.hung,
        )

    def structure(self, u: Real) -> tuple[Structure, Complex]:
        """Without any change, and its flexibility (lines, modes, modes)."""
        key = u.tobytes()
        if key not in self.last:
            found = self._structure(u)
            self.last.clear()
            self.last[key] = found, found.flexibility(self.of.s)
        return self.last[key]

    def _structure(self, u: Real) -> Structure:
        kappa, mu, field, zeta, *_, masses, across = self.parts(u)
        c, e, damped = self.of, np.zeros((self.modes, self.modes)), np.zeros((self.modes, self.modes))
        e[np.triu_indices(self.modes)] = field
        for (r, q), value in zip(c.close_pairs, across, strict=True):
            damped[r, q] = damped[q, r] = value
        return Structure(
            omega=2 * np.pi * c.model.frequency_hz,
            zeta=c.model.damping_ratio * np.exp(zeta),
            stiffness=float(np.exp(kappa[0])),
            mass=float(np.exp(mu[0])),
            field=e + np.triu(e, 1).T,
            across=damped,
            sensor_masses=masses,
            sensor_shapes=c.response_factors if c.shapes.scaled else 0 * c.response_factors,
        )

    def predicted(self, u: Real, change: Change = NOTHING) -> Complex:
        """(lines, outputs, inputs) receptances."""
        state = self.state(u, change)
        return state.receptance(self.of.s, self.of.outside.scaled(state.structure.stiffness, state.structure.mass))

    def derivatives(self, u: Real, change: Change = NOTHING) -> Complex:
        """(numbers, lines, outputs, inputs) of what is predicted, by each number in its own unit."""
        return derivatives(self.of, self.state(u, change), self.sizes)

    def residual(self, u: Real, change: Change = NOTHING) -> Real:
        """(2 lines outputs inputs,) predicted less measured, in deviations."""
        return self.weighed((self.predicted(u, change) - self.of.measured)[None])[:, 0]

    def weighed(self, misfits: Complex) -> Real:
        """(2 lines outputs inputs, any) of misfits (any, lines, outputs, inputs), in deviations."""
        return self.of.weights.weighed(misfits) / self.loose

    def slopes(self, u: Real, change: Change = NOTHING) -> Real:
        """(2 lines outputs inputs, numbers) derivatives of `residual`."""
        return self.weighed(self.derivatives(u, change)) * self.deviations

    def missed(self, u: Real, change: Change = NOTHING) -> Real:
        """(lines, outputs, inputs) |predicted less measured| over measured; small FRFs count as in `Compared.sizes`."""
        return np.abs(self.predicted(u, change) - self.of.measured) / self.of.sizes

    def share(self, u: Real, change: Change = NOTHING) -> float:
        """Rms over all of them."""
        return float(np.sqrt(np.mean(self.missed(u, change) ** 2)))
