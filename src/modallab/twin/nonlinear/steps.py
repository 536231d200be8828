"""A beam and an element made ready to be stepped in time, with steps of one length."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.twin.elements import shape_rows
from modallab.twin.modes import TwinModes
from modallab.twin.nonlinear.element import ModalCoupling, NonlinearLaw

SWIFT = 1.7
"""Radians in a step from which a mode follows the forces at once: an element that is stiff beside it would not settle
where its own oscillation is stepped over."""
OF_ONE_MOTION = (NonlinearLaw.CUBIC, NonlinearLaw.FRICTION, NonlinearLaw.PLAY)
ROW = 16
"""Powers of a step that the others are products of."""
CHUNK = ROW**2
"""Steps that a known force is taken in."""


@dataclass(frozen=True, eq=False, slots=True)
class ElementForces:
    """The forces of an element from a step on, and the modes they act on.

    The state s of the modes goes on by s[i + 1] = decay s[i] + acts F[i], and their motion is s[i] + at_once F[i].

    Attributes:
        decay: (kept,) of a step.
        acts: (f, kept) what a unit of each force adds to the state.
        at_once: (f, kept) what it adds to the modes at once.
        begun: (kept,) state before the first step.
        forces: (f, steps) N of the element's channels, then, if there is any, what each has more than its straight
            line.
        channels: of the element.
        left: see `Steps.left`.
    """

    decay: Complex
    acts: Complex
    at_once: Complex
    begun: Complex
    forces: Real
    channels: int
    left: Callable[[Real], Complex]

    def motion(self, steps: int | None = None) -> Real:
        """(2 kept, steps) of the modes that the element adds, real parts and then imaginary ones; all, or the first."""
        # Loaded where it is needed: what is linear needs no compiled loop.
        from modallab.twin.nonlinear.stepping import modes_under_forces

        forces, kept = np.ascontiguousarray(self.forces[:, :steps].T), len(self.decay)
        acts, at_once = _pad_to_lanes(self.acts), _pad_to_lanes(self.at_once)
        out = np.empty((len(forces), *acts.shape[1:]))
        modes_under_forces(_pad_to_lanes(self.decay), acts, at_once, _pad_to_lanes(self.begun), forces, out)
        return out[:, :, :kept].reshape(len(out), -1).T


def _pad_to_lanes(values: Complex) -> Real:
    """(..., 2, p) real and imaginary parts of (..., kept), p a multiple of LANES."""
    from modallab.twin.nonlinear.stepping import LANES

    kept = values.shape[-1]
    found = np.zeros((*values.shape[:-1], 2, -(-kept // LANES) * LANES))
    found[..., 0, :kept], found[..., 1, :kept] = values.real, values.imag
    return found


@dataclass(frozen=True, eq=False, slots=True)
class ModalSteps:
    """What a step does to the modes, in the terms of `stepping`.

    Attributes:
        own: the element on the modes.
        kept: modes that are followed in time.
        decay: (kept,) of a step.
        push: (m, kept) what a unit of the element's force adds to the state of the modes.
        late: (m, kept) what it adds to the modes at once.
        drive: (kept,) what a unit of the known force adds to their state.
        drive_late: (kept,) what that adds at once.
        static: (m, m) m/N at the element of what follows its force at once.
        direct: (1 + m,) m/N there of what follows the known force at once.
        kick: (m, kept) what 1 N over a step adds to the state, as impulses at both of its ends.
        poles: (kept,) rad/s.
        chunk: (CHUNK, 2 kept) what is left of each of so many steps after the last, real and imaginary parts.
    """

    own: ModalCoupling
    kept: int
    decay: Complex
    push: Complex
    late: Complex
    drive: Complex
    drive_late: Complex
    static: Real
    direct: Real
    kick: Complex
    poles: Complex
    chunk: Real

    @classmethod
    def of(cls, modes: TwinModes, own: ModalCoupling, h: float, x_m: float) -> Self:
        """Of a beam that a known force drives at `x_m`, in steps of `h` s."""
        kept = int(np.count_nonzero(np.abs(modes.poles) * h < SWIFT))
        poles, shapes = modes.poles[:kept], own.shapes[:, :kept]
        x = poles * h
        first = np.expm1(x) / x
        second = (np.expm1(x) - x) / x**2
        decay, early, late = np.exp(x), h * (first - second), h * second
        load = shape_rows(x_m, modes.length_m)[0]
        drive = load @ modes.columns[:, :kept]
        after = decay * late + early
        swift = np.real(-2 * modes.columns[:, kept:] / modes.poles[kept:] @ modes.columns[:, kept:].T)
        at_once = modes.out_of_band + swift
        static, direct = own.rows[1:] @ at_once @ own.rows[1:].T, own.rows @ (at_once @ load)
        few, many = (np.exp(x * every * np.arange(ROW)[:, None]) for every in (1, ROW))
        left = (many[:, None] * few).reshape(CHUNK, kept)[::-1]
        chunk = np.concatenate([np.real(left), np.imag(left)], axis=1)
        pushes = after * shapes, late * shapes, after * drive, late * drive
        kick = h / 2 * (1 + decay) * shapes
        return cls(own, kept, decay, *pushes, static, direct, kick, poles, chunk)

    def state_after(self, force: Real) -> Complex:
        """(kept,) state in which a known force (steps,) from rest leaves the modes by itself."""
        return self.drive * self.remaining_motion(force[None])[0]

    def remaining_motion(self, forces: Real) -> Complex:
        """(f, kept) sum of the steps of forces (f, steps), each by what is left of it after the last."""
        short = -forces.shape[1] % CHUNK
        chunks = np.concatenate([np.zeros((len(forces), short)), forces], axis=1).reshape(len(forces), -1, CHUNK)
        parts = chunks @ self.chunk
        later = np.exp(CHUNK * np.log(self.decay) * np.arange(chunks.shape[1])[::-1, None])
        return np.sum((parts[..., : self.kept] + 1j * parts[..., self.kept :]) * later, axis=1)

    def run(self, force: Real, skip: int) -> ElementForces:
        """Step the element under a known force.

        Args:
            force: (steps,) N.
            skip: steps before the first that is kept.
        """
        width, count = _pad_to_lanes(self.decay).shape[-1], len(self.own.shapes)
        total, pushed = np.zeros((2, width)), np.zeros((len(force) - skip, count))
        excess = np.zeros_like(pushed)
        (self._run_one if self.own.law in OF_ONE_MOTION else self._run_many)(force, skip, total, pushed, excess)
        state = np.empty(self.kept, dtype=complex)
        state.real, state.imag = total[:, : self.kept]
        state -= self.state_after(force[:skip])
        if not np.any(excess):
            return ElementForces(self.decay, self.push, self.late, state, pushed.T, count, self.remaining_motion)
        acts, at_once = (np.concatenate(rows) for rows in ((self.push, self.decay * self.kick), (self.late, self.kick)))
        return ElementForces(
            self.decay, acts, at_once, state, np.concatenate([pushed, excess], axis=1).T, count, self.remaining_motion
        )

    def _run_one(self, force: Real, skip: int, begun: Real, pushed: Real, excess: Real) -> None:
        from modallab.twin.nonlinear.stepping import step_one

        seen, push, later = 2 * self.own.shapes[0, : self.kept], self.push[0], self.decay * self.kick[0]
        own: Real = np.real(np.array([self.late[0], push, later]) @ seen).astype(np.float64)
        own[0] += self.static[0, 0]
        known: Real = np.real(np.array([self.drive_late, self.drive]) @ seen).astype(np.float64)
        known[0] += self.direct[1]
        step_one(
            int(self.own.law),
            np.array((*self.own.numbers, 0.0, 0.0)[:3]),
            _pad_to_lanes(self.decay),
            _pad_to_lanes(push),
            _pad_to_lanes(self.drive),
            _pad_to_lanes(seen * self.decay),
            _pad_to_lanes(later),
            own,
            known,
            force,
            skip,
            begun,
            pushed.reshape(-1),
            excess.reshape(-1),
        )

    def _run_many(self, force: Real, skip: int, begun: Real, pushed: Real, excess: Real) -> None:
        from modallab.twin.nonlinear.stepping import step_many

        cracked, shapes = self.own.law is NonlinearLaw.CRACK, self.own.shapes[:, : self.kept]
        felt = 2 * np.concatenate([self.own.switch[None, : self.kept], shapes * (1.0 if cracked else self.poles)])
        whole = np.eye(len(shapes)) - self.static - 2 * np.real(self.late @ shapes.T)
        step_many(
            int(self.own.law),
            np.array(self.own.numbers),
            np.asarray(np.linalg.inv(whole) if cracked else whole, dtype=np.float64),
            _pad_to_lanes(self.decay),
            _pad_to_lanes(np.concatenate([self.push, self.drive[None], self.decay * self.kick])),
            _pad_to_lanes(felt),
            (self.direct if cracked else 0.0) + np.real(felt @ self.drive_late),
            np.real(felt @ self.late.T),
            force,
            skip,
            begun,
            pushed,
            excess,
        )
