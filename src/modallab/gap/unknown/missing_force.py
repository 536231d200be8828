"""The force that is missing, estimated as an input at one place after another along the beam.

On every line of a hit the residual is what an unknown force at x would leave on all accelerometers: one complex number
to many channels, by weighted least squares (an input observer in the frequency domain; Maes, Gillijns and Lombaert,
Mech. Syst. Signal Process. 98, 2018, 747, on what makes such an input identifiable). Beside it the beam's own numbers
are free within their priors, to first order, and so is the state of each mode at the end of the block, which a force
that is not known has left there. All three are linear; the forces are projected out line by line (Golub and Pereyra,
SIAM J. Numer. Anal. 10, 1973, 413).
"""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.gap.conditioning.rows import ImpactData, Reduced
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.model.forward import forward, frequency_ratios_of_hits, with_clock_error
from modallab.gap.model.minimise import jacobian
from modallab.twin.bench import Twin, chain_transfer
from modallab.twin.modes import TwinModes, solve_modes
from modallab.twin.predict import sensor_positions

PLACES = tuple(float(x) for x in np.linspace(0.04, 1.0, 25))
"""Shares of the length at which a force is tried."""


@dataclass(frozen=True, eq=False, slots=True)
class ForceEstimate:
    """A force at one place.

    Attributes:
        x: its place, a share of the length.
        left: squares in noise units that stay.
        count: numbers they are of.
        s: (lines,) rad/s, of all drive points side by side.
        force: (lines,) N per N of the drive.
        motion: (lines,) displacement there in m per N, the missing force's own part included.
        sigma: (lines,) standard deviation of either part of the force.
    """

    x: float
    left: float
    count: int
    s: Complex
    force: Complex
    motion: Complex
    sigma: Real


class MissingForce:
    """The residual of a fit on hits, ready for a force at any place."""

    def __init__(self, fit: Fit, data: Reduced) -> None:
        """Linearise about a fit.

        Args:
            fit: the twin without effects.
            data: records with hits.
        """
        self._data = replace(data, sines=None)
        problem = Problem(self._data, fit.problem.free)
        self._twin = problem.twin(fit.u)
        self._modes = solve_modes(self._twin.structure)
        answers = forward(self._twin, self._data)
        r = problem.residual_of(self._twin, answers)
        J = jacobian(problem, fit.u, r)
        self._priors = problem.priors(fit.u)
        self._parts = _split_slopes(self._data, J)
        self._residual = [
            np.where(np.isfinite(d.rows.sigma), d.rows.in_noise_units(d.rows.y - y), 0j)
            for d, y in zip(self._data.impacts, answers, strict=True)
        ]
        self._ringing_at_end = [_ringing_at_end(self._twin, self._modes, d, self._data) for d in self._data.impacts]

    def at(self, x: float) -> ForceEstimate:
        """The force at a share of the length that leaves least."""
        place = x * self._twin.structure.length_m
        own = [self._unit_response(d, place) for d in self._data.impacts]
        free = self._parts[0].shape[0]
        sizes = [len(e) for e in self._ringing_at_end]
        size = free + sum(sizes)
        normal, gradient = np.zeros((size, size)), np.zeros(size)
        _, slope, weight = self._priors
        normal[range(free), range(free)] = weight
        gradient[:free] = slope
        bare: list[Complex] = []
        stacks: list[Complex] = []
        first = free
        for r, J, ends, h in zip(self._residual, self._parts, self._ringing_at_end, own, strict=True):
            columns = _without_line_forces(np.concatenate([J, ends]), h)
            rest = _without_line_forces(r[None], h)[0]
            at = np.r_[0:free, first : first + len(ends)]
            flat = columns.reshape(len(columns), -1).view(np.float64)
            normal[np.ix_(at, at)] += flat @ flat.T
            gradient[at] += flat @ np.ascontiguousarray(rest).reshape(-1).view(np.float64)
            bare.append(rest)
            stacks.append(columns)
            first += len(ends)
        normal[range(free, size), range(free, size)] += 1e-9 * np.trace(normal) / size
        step: Real = -np.linalg.solve(normal, gradient).astype(np.float64)
        return self._least_squares(x, place, own, step, bare, stacks)

    def _least_squares(
        self, x: float, place: float, own: list[Complex], step: Real, bare: list[Complex], stacks: list[Complex]
    ) -> ForceEstimate:
        free, first, left, count = self._parts[0].shape[0], self._parts[0].shape[0], 0.0, 0
        lines: list[Complex] = []
        forces: list[Complex] = []
        motions: list[Complex] = []
        sigmas: list[Real] = []
        zipped = zip(
            self._data.impacts, self._residual, self._parts, self._ringing_at_end, own, bare, stacks, strict=True
        )
        for d, r, J, ends, h, rest, columns in zipped:
            moved = np.concatenate([step[:free], step[first : first + len(ends)]])
            first += len(ends)
            left += float(np.sum(np.abs(rest + np.tensordot(moved, columns, 1)) ** 2))
            count += 2 * int(np.count_nonzero(r))
            size: Real = np.maximum(np.sum(np.abs(h) ** 2, axis=0), 1e-300).astype(np.float64)
            whole = r + np.tensordot(moved, np.concatenate([J, ends]), 1)
            force = np.sum(h.conj() * whole, axis=0) / size
            lines.append(with_clock_error(d.source, self._twin).s)
            forces.append(force)
            motions.append(self._motion(d, place, force))
            sigmas.append(1 / np.sqrt(size))
        _, _, weight = self._priors
        left += float(np.sum(weight * step[:free] ** 2))
        s, force, motion = (np.concatenate(parts) for parts in (lines, forces, motions))
        return ForceEstimate(x, left, count, s, force, motion, np.concatenate(sigmas))

    def _unit_response(self, d: ImpactData, place: float) -> Complex:
        """(channels, lines) what a unit force at a place leaves, in noise units."""
        s = with_clock_error(d.source, self._twin).s
        y = (
            s**2
            * chain_transfer(self._twin.chain, self._data.channels, s)
            * self._compliance(self._sensors(), place, s)
        )
        return np.where(np.isfinite(d.rows.sigma), d.rows.in_noise_units(y), 0j)

    def _motion(self, d: ImpactData, place: float, force: Complex) -> Complex:
        twin, s = self._twin, with_clock_error(d.source, self._twin).s
        struck = twin.struck_x_m(d.piece.drive_x_m)
        own, x = twin.hit_gain(d.piece.drive_x_m), np.array([place])
        return own * self._compliance(x, struck, s)[0] + force * self._compliance(x, place, s)[0]

    def _compliance(self, x_m: Real, place: float, s: Complex) -> Complex:
        """(points, lines) displacement per N at a place."""
        modes = self._modes
        residue = modes.shapes_at(x_m) * modes.shapes_at(place)[0]
        total = residue @ (1 / (s - modes.poles[:, None])) + residue.conj() @ (1 / (s - modes.poles.conj()[:, None]))
        return total + self._twin.residual_compliance * modes.remainder(x_m, place)[:, None]

    def _sensors(self) -> Real:
        return sensor_positions(self._twin.chain, self._modes, self._data.channels, self._data.x_m)


def _split_slopes(data: Reduced, J: Real) -> list[Complex]:
    """For each part of the data its (free, channels, lines) slopes."""
    sizes = [d.rows.y.size for d in data.impacts]
    half, found, at = sum(sizes), list[Complex](), 0
    for d, size in zip(data.impacts, sizes, strict=True):
        real, imag = J[at : at + size], J[half + at : half + at + size]
        found.append((real + 1j * imag).T.reshape(-1, *d.rows.y.shape))
        at += size
    return found


def _ringing_at_end(twin: Twin, modes: TwinModes, d: ImpactData, data: Reduced) -> Complex:
    """(2 p, channels, lines) what modes leave that ring on at the end of the block, in noise units.

    One column for the real and one for the imaginary part of each.
    """
    source = with_clock_error(d.source, twin)
    # What has died away by the end leaves nothing.
    block_s = source.n * source.dt
    rings = np.exp(modes.poles.real * block_s) > 1e-7
    poles = modes.poles[rings]
    psi = modes.shapes_at(sensor_positions(twin.chain, modes, data.channels, data.x_m))[:, rings]
    columns: list[Complex] = []
    ratios = frequency_ratios_of_hits(twin, d, data)
    amplitude = psi * poles**2 * chain_transfer(twin.chain, data.channels, poles)
    conjugate = psi.conj() * poles.conj() ** 2 * chain_transfer(twin.chain, data.channels, poles.conj())
    _, tail = source.response_to_unit_residue(poles, ratios)
    _, tail_conj = source.response_to_unit_residue(poles.conj(), ratios)
    for p in range(len(poles)):
        up, down = np.outer(amplitude[:, p], tail[p]), np.outer(conjugate[:, p], tail_conj[p])
        for column in (up + down, 1j * (up - down)):
            white: Complex = np.where(np.isfinite(d.rows.sigma), d.rows.in_noise_units(column), 0j)
            columns.append(white / max(float(np.linalg.norm(white)), 1e-300))
    shape = (0, *d.rows.y.shape)
    return np.array(columns) if columns else np.zeros(shape, dtype=np.complex128)


def _without_line_forces(columns: Complex, h: Complex) -> Complex:
    """(k, channels, lines) without what a force on each line explains."""
    size = np.maximum(np.sum(np.abs(h) ** 2, axis=0), 1e-300)
    along = np.einsum("cl,kcl->kl", h.conj(), columns) / size
    return np.ascontiguousarray(columns - h * along[:, None, :])
