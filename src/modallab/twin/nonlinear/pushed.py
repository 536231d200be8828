"""What an element does to the modes, step by step: its forces, and the motion that follows from them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Complex, Real


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
        acts, at_once = pad_to_lanes(self.acts), pad_to_lanes(self.at_once)
        out = np.empty((len(forces), *acts.shape[1:]))
        modes_under_forces(pad_to_lanes(self.decay), acts, at_once, pad_to_lanes(self.begun), forces, out)
        return out[:, :, :kept].reshape(len(out), -1).T


def pad_to_lanes(values: Complex) -> Real:
    """(..., 2, p) real and imaginary parts of (..., kept), p a multiple of LANES."""
    from modallab.twin.nonlinear.stepping import LANES

    kept = values.shape[-1]
    found = np.zeros((*values.shape[:-1], 2, -(-kept // LANES) * LANES))
    found[..., 0, :kept], found[..., 1, :kept] = values.real, values.imag
    return found
