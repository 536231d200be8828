"""The simulation with what a diagnosis found in it: its FRFs, its state space, its answer to a force."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from modallab.core.arrays import Real
from modallab.core.errors import DataError
from modallab.core.frf import DERIVATIVES, FrfQuantity
from modallab.core.rig import Rig
from modallab.modification.state_space import SteppedModes
from modallab.notebook.measured_frf import MeasuredFrf, frf
from modallab.twin.bench import Twin
from modallab.twin.modes import TwinModes, solve_modes


class TwinStateSpace(NamedTuple):
    """x' = A x + B f, y = C x + D f, with the force f in N.

    Attributes:
        A: (states, states) two states for each mode.
        B: (states, 1).
        C: (outputs, states).
        D: (outputs, 1).
    """

    A: Real
    B: Real
    C: Real
    D: Real


@dataclass(eq=False, slots=True, repr=False)
class DiagnosedTwin:
    """The beam with the effects of a diagnosis, as a linear model of the structure without its measurement chain.

    Attributes:
        twin: beam, chain and effects.
        rig: description of the bench.
    """

    twin: Twin
    rig: Rig
    _steps: SteppedModes = field(default_factory=SteppedModes, init=False)
    _driven: int = field(default=0, init=False)

    @property
    def points(self) -> tuple[int, ...]:
        """The points that have a sensor, in the order of every output here."""
        return tuple(c.point for c in self.rig.responses if c.point is not None)

    def frf(self, f: ArrayLike, drive: int | None = None, quantity: FrfQuantity = "inertance") -> MeasuredFrf:
        """FRFs from a force at one point to every sensor.

        Args:
            f: (lines,) frequencies in Hz, above 0 and ascending.
            drive: point of the force; None for the shaker's.
            quantity: inertance, mobility or receptance.

        Raises:
            DataError: frequencies that do not ascend.
            RigError: no such point.
        """
        modes, point = self._modes(), self._drive(drive)
        hz = np.atleast_1d(np.asarray(f, dtype=np.float64))
        s, x = 2j * np.pi * hz, self._places()
        residue = modes.shapes_at(x) * modes.shapes_at(self.rig.x_of(point))[0]
        values = residue @ (1 / (s - modes.poles[:, None])) + residue.conj() @ (1 / (s - modes.poles.conj()[:, None]))
        values += self.twin.residual_compliance * modes.remainder(x, self.rig.x_of(point))[:, None]
        return frf(hz, values * s ** DERIVATIVES[quantity], inputs=point, outputs=self.points, quantity=quantity)

    def state_space(self, drive: int | None = None, quantity: FrfQuantity = "inertance") -> TwinStateSpace:
        """Matrices from a force at one point in N to the motion of every sensor, continuous in time.

        The compliance of higher modes has no state, and is left out.

        Args:
            drive: point of the force; None for the shaker's.
            quantity: inertance for accelerations, mobility for velocities, receptance for displacements as outputs.

        Raises:
            RigError: no such point.
        """
        modes, b = self._modes(), self._input(self._drive(drive))
        c, d = self._output(modes, b, quantity)
        n = len(modes.poles)
        a = np.zeros((2 * n, 2 * n))
        u, v = np.arange(n), np.arange(n, 2 * n)
        a[u, u] = a[v, v] = modes.poles.real
        a[u, v], a[v, u] = -modes.poles.imag, modes.poles.imag
        return TwinStateSpace(
            a, np.concatenate([b.real, b.imag])[:, None], 2 * np.concatenate([c.real, -c.imag], axis=1), d[:, None]
        )

    def step(self, force: ArrayLike, dt: float, drive: int | None = None) -> Real:
        """Accelerations in m/s^2 at every sensor under a force; continues from the last step.

        Between two samples the force is linear; each mode is exact for such a force.

        Args:
            force: in N: one number, or (n,) samples.
            dt: length of a step in s.
            drive: point of the force; None for the shaker's. Another point restarts from rest.

        Returns:
            (outputs,) for one number, else (outputs, n), at the samples of the force.

        Raises:
            DataError: a step that is not above 0, or a force that is not finite.
        """
        samples = np.atleast_1d(np.asarray(force, dtype=np.float64))
        if not (np.isfinite(dt) and dt > 0) or not np.isfinite(samples).all() or samples.ndim != 1:
            raise DataError(
                f"a step of {dt:g} s, or the force, cannot be", remedy="give dt above 0 s, and finite forces"
            )
        modes, point = self._modes(), self._drive(drive)
        b = self._input(point)
        c, d = self._output(modes, b, "inertance")
        if point != self._driven:
            self._steps, self._driven = SteppedModes(), point
        states = self._steps.step(modes.poles, b, samples, dt)
        answer = 2 * np.real(c @ states) + d[:, None] * samples
        return answer[:, 0] if np.ndim(force) == 0 else answer

    def reset(self) -> None:
        """Return to rest before the next step."""
        self._steps = SteppedModes()

    def _modes(self) -> TwinModes:
        return solve_modes(self.twin.structure)

    def _drive(self, point: int | None) -> int:
        return point if point is not None else self.rig.shaker_point or self.points[-1]

    def _places(self) -> Real:
        return np.array([self.rig.x_of(point) for point in self.points])

    def _input(self, point: int) -> NDArray[np.complex128]:
        return self._modes().shapes_at(self.rig.x_of(point))[0].astype(np.complex128)

    def _output(
        self, modes: TwinModes, b: NDArray[np.complex128], quantity: FrfQuantity
    ) -> tuple[NDArray[np.complex128], Real]:
        """(outputs, modes) and (outputs,) of the motion's derivative that the quantity measures."""
        times, shapes = DERIVATIVES[quantity], modes.shapes_at(self._places())
        # Of the displacement and the velocity the modes' shares of a jump of the force cancel.
        direct = 2 * np.real((shapes * modes.poles) @ b) if times == 2 else np.zeros(len(shapes))
        return (shapes * modes.poles**times).astype(np.complex128), direct

    def __repr__(self) -> str:
        hz = ", ".join(f"{f:.4g}" for f in self._modes().frequency_hz[:3])
        return f"<DiagnosedTwin of {self.rig.name!r}: modes at {hz}, ... Hz>"
