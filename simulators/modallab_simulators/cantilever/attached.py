"""Modes of a structure with masses and springs attached, and with a root that shifts.

Rayleigh-Ritz on the first modes of the bare structure, joined by what the others answer statically to a load at each
attachment and, for a root that shifts, by the shift itself. With W the first N modes and s_a the static answer of all
beyond to a unit load at attachment a, both mass and stiffness are known in closed form: s_a is orthogonal to W in both,
its stiffness is the residual flexibility, its mass the sum of phi_a phi_b / omega^4 over the modes beyond. So the error
falls with a high power of N (Craig and Kurdila, Fundamentals of Structural Dynamics, ch. 17), for a rotational spring
as for a mass.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

import numpy as np

from modallab.core.arrays import Real
from modallab.core.errors import ConfigurationError
from modallab_simulators.cantilever.modes import Modes, SolvedModes, eigh

KEPT = 80
SUMMED = 160
"""Number of modes of the bare structure that are kept, and number up to which the flexibility of the rest is summed."""

_NOTHING = 1e-9
_SAME = 1e-6
"""Share of the length below which two attachments are one: their static answers would be the same."""


@dataclass(frozen=True, slots=True)
class Attachment:
    """A mass and a spring to ground on the displacement (order 0) or the slope (1) at `x_m`."""

    x_m: float
    order: int = 0
    mass: float = 0.0
    stiffness: float = 0.0


@dataclass(frozen=True, slots=True)
class Absorber:
    """A mass that hangs at `x_m` on a spring."""

    x_m: float
    mass_kg: float
    stiffness_n_m: float


class AttachedModes(SolvedModes):
    """A structure with attachments, behind the interface of its modes.

    Args:
        bare: the structure without.
        attachments: at places off the root; one on the root changes nothing.
        root_n_m: spring against which the root shifts; inf is held.
        absorbers: masses on springs, off the root too.
    """

    def __init__(
        self,
        bare: Modes,
        attachments: Sequence[Attachment],
        root_n_m: float = inf,
        absorbers: Sequence[Absorber] = (),
    ) -> None:
        super().__init__(bare)
        self._root, self._absorbers = root_n_m, tuple(absorbers)
        # Where an absorber hangs, the beam needs what a load there bends.
        attachments = [*attachments, *(Attachment(a.x_m) for a in absorbers)]
        off_root = [a for a in attachments if a.x_m > _NOTHING * bare.length_m]
        self._at = _together(off_root, _SAME * bare.length_m)

    @property
    def total_mass_kg(self) -> float:
        """Of the beam and the masses on it."""
        masses = [a.mass for a in self._at if a.order == 0] + [a.mass_kg for a in self._absorbers]
        return self._bare.total_mass_kg + sum(masses)

    def shapes(self, x_m: Real, count: int, order: int = 0) -> Real:
        """Displacement or slope of the modes, (points, count)."""
        return self._basis(x_m, order) @ self._solved[1][:, :count]

    def attached_modes(self) -> list[int]:
        """For each absorber the mode that is most its own."""
        vectors, count = self._solved[1], len(self._absorbers)
        hung = vectors[len(vectors) - count :]
        return [int(np.argmax(np.abs(row))) for row in hung]

    def participation(self, count: int) -> Real:
        """Integral of mass times shape, in kg^1/2, (count,)."""
        hung = np.array([a.mass_kg for a in self._absorbers])
        own = np.concatenate([self._bare.participation(KEPT), self._shift_mass, self._residual_moment, hung])
        total = own @ self._solved[1][:, :count]
        for attachment, row in zip(self._at, self._rows, strict=True):
            if attachment.order == 0:
                total += attachment.mass * (row @ self._solved[1][:, :count])
        return total

    def flexibility(self, x_m: Real, force_x_m: float, seen: int = 0, put: int = 0) -> Real:
        """Static answer at `x_m` to a load at `force_x_m`, (points,)."""
        plain = self._held(x_m, force_x_m, seen, put)
        springs = [a for a in self._at if a.stiffness]
        if not springs:
            return plain
        to = np.stack([self._held(x_m, a.x_m, seen, a.order) for a in springs], axis=1)
        load = np.array([self._held(np.array([a.x_m]), force_x_m, a.order, put)[0] for a in springs])
        among = np.array(
            [[self._held(np.array([a.x_m]), b.x_m, a.order, b.order)[0] for b in springs] for a in springs]
        )
        return plain - to @ np.linalg.solve(np.diag([1 / a.stiffness for a in springs]) + among, load)

    def _held(self, x_m: Real, force_x_m: float, seen: int, put: int) -> Real:
        shift = 1 / self._root if seen == put == 0 else 0.0
        return self._bare.flexibility(x_m, force_x_m, seen, put) + shift

    @property
    def _shifts(self) -> bool:
        return self._root != inf

    @property
    def _shift_mass(self) -> Real:
        return np.array([self._bare.total_mass_kg]) if self._shifts else np.zeros(0)

    def _of_each(self, count: int) -> Real:
        """What the bare modes do at each attachment, (attachments, count)."""
        rows = np.empty((len(self._at), count))
        for order in (0, 1):
            chosen = [k for k, a in enumerate(self._at) if a.order == order]
            if chosen:
                rows[chosen] = self._bare.shapes(np.array([self._at[k].x_m for k in chosen]), count, order)
        return rows

    @cached_property
    def _there(self) -> Real:
        return self._of_each(KEPT)

    @cached_property
    def _residual(self) -> Real:
        """What the modes above the kept ones do at each attachment, over omega^2, (attachments, modes)."""
        return self._of_each(SUMMED)[:, KEPT:] / self._bare.omega(SUMMED)[KEPT:] ** 2

    @property
    def _residual_moment(self) -> Real:
        return self._residual @ self._bare.participation(SUMMED)[KEPT:]

    def _basis(self, x_m: Real, order: int) -> Real:
        """The Ritz vectors at some points, (points, vectors)."""
        modes = self._bare.shapes(x_m, KEPT, order)
        columns = [modes]
        if self._shifts:
            columns.append(np.full((len(x_m), 1), 1.0 if order == 0 else 0.0))
        over = modes / self._bare.omega(KEPT) ** 2
        for a, there in zip(self._at, self._there, strict=True):
            columns.append((self._bare.flexibility(x_m, a.x_m, order, a.order) - over @ there)[:, None])
        columns.append(np.zeros((len(x_m), len(self._absorbers))))
        return np.concatenate(columns, axis=1)

    @cached_property
    def _rows(self) -> Real:
        """The Ritz vectors at each attachment, (attachments, vectors)."""
        rows = [self._basis(np.array([a.x_m for a in self._at]), order) for order in (0, 1)]
        return np.array([rows[a.order][k] for k, a in enumerate(self._at)]).reshape(rows[0].shape)

    @cached_property
    def _solved(self) -> tuple[Real, Real]:
        mass, stiffness = self._bare_matrices()
        for a, row in zip(self._at, self._rows, strict=True):
            mass += a.mass * np.outer(row, row)
            stiffness += a.stiffness * np.outer(row, row)
        for place, absorber in enumerate(reversed(self._absorbers), 1):
            stretch = self._basis(np.array([absorber.x_m]), 0)[0]
            stretch[-place] -= 1.0
            mass[-place, -place] = absorber.mass_kg
            stiffness += absorber.stiffness_n_m * np.outer(stretch, stretch)
        # At unit mass each, vectors of very different size can share one factorisation.
        scale = np.diag(mass) ** -0.5
        values, vectors = eigh(stiffness * np.outer(scale, scale), mass * np.outer(scale, scale))
        if values[0] <= 0:
            raise ConfigurationError(
                f"parts attached to the beam at {', '.join(f'{a.x_m:g}' for a in self._at)} m give the beam an "
                f"unstable mode: omega^2 = {values[0]:.3g} 1/s^2",
                remedy="give masses and springs greater than 0, and places further apart",
            )
        return np.sqrt(values), vectors * scale[:, None]

    def _bare_matrices(self) -> tuple[Real, Real]:
        shifts, last = len(self._shift_mass), KEPT + len(self._shift_mass) + len(self._at)
        n = last + len(self._absorbers)
        mass, stiffness = np.eye(n), np.zeros((n, n))
        stiffness[:KEPT, :KEPT] = np.diag(self._bare.omega(KEPT) ** 2)
        residual = slice(KEPT + shifts, last)
        mass[residual, residual] = self._residual @ self._residual.T
        stiffness[residual, residual] = self._rows[:, residual]
        if shifts:
            mass[KEPT, KEPT], stiffness[KEPT, KEPT] = self._bare.total_mass_kg, self._root
            mass[KEPT, :KEPT] = mass[:KEPT, KEPT] = self._bare.participation(KEPT)
            mass[KEPT, residual] = mass[residual, KEPT] = self._residual_moment
        return mass, stiffness


def _together(attachments: Sequence[Attachment], same_m: float) -> tuple[Attachment, ...]:
    """One attachment a place: two of the same kind there are their sum, and bend the beam alike."""
    found: list[Attachment] = []
    for a in attachments:
        at = next((k for k, f in enumerate(found) if f.order == a.order and abs(f.x_m - a.x_m) < same_m), None)
        if at is None:
            found.append(a)
        else:
            former = found[at]
            found[at] = replace(former, mass=former.mass + a.mass, stiffness=former.stiffness + a.stiffness)
    return tuple(found)
