"""Modes as a state space: what simulators and control design take."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy import signal
from scipy.io import savemat

from modallab.core.arrays import Complex, Real
from modallab.core.discovery import optional_package
from modallab.core.documents.model_use import StateSpaceMatrices
from modallab.core.errors import StorageError
from modallab.core.units import DERIVATIVE, SI_UNIT, Quantity
from modallab.formats.atomic import replacing
from modallab.modification.response import ramp_weights


class StateSpaceModel(StateSpaceMatrices):
    """A state space for simulators and control design."""

    def __repr__(self) -> str:
        sizes = f"{len(self.A)} states, {len(self.inputs)} forces, {len(self.outputs)} outputs"
        return f"<StateSpaceModel: {sizes}, {self.unit}>"

    def scipy(self) -> Any:
        """As `scipy.signal.StateSpace`."""
        return signal.StateSpace(self.A, self.B, self.C, self.D)

    def control(self) -> Any:
        """As `control.StateSpace` of python-control, with names.

        Raises:
            MissingPackageError: python-control is not installed.
        """
        control = optional_package("control", "state_space.control()")
        return control.ss(self.A, self.B, self.C, self.D, inputs=list(self.inputs), outputs=list(self.outputs))

    def save(self, path: str | Path) -> Path:
        """Write it as a MATLAB file; returns the path.

        Raises:
            StorageError: the name ends otherwise, or the file cannot be written.
        """
        path = Path(path)
        if path.suffix != ".mat":
            raise StorageError(f"{path.name} does not end with .mat", where=str(path), remedy="name it model.mat")
        with replacing(path) as draft:
            savemat(str(draft), dict(self), appendmat=False)
        return path


def state_space_of(
    poles: Complex,
    sigma: tuple[Real, Real],
    out: Complex,
    into: Complex,
    quantity: Quantity,
    outputs: Sequence[object],
    inputs: Sequence[object],
) -> StateSpaceModel:
    """The state space of modes, without what lies outside the band.

    Args:
        poles: (modes,) rad/s.
        sigma: (modes,) of frequencies in Hz, and of damping ratios.
        out: (modes, outputs) psi.
        into: (modes, inputs) psi.
        quantity: displacement, velocity or acceleration.
        outputs: their points.
        inputs: their points.
    """
    a = np.block([[np.diag(poles.real), -np.diag(poles.imag)], [np.diag(poles.imag), np.diag(poles.real)]])
    c = (out * poles[:, None] ** DERIVATIVE[quantity]).T
    # A force accelerates at once; in displacement and velocity the modes' shares of it cancel.
    direct = 2 * np.real((out * poles[:, None]).T @ into) if quantity == "acceleration" else 0 * np.real(out.T @ into)
    return StateSpaceModel(
        A=np.asarray(a, np.float64),
        B=np.asarray(np.concatenate([into.real, into.imag]), np.float64),
        C=2 * np.concatenate([c.real, -c.imag], axis=1),
        D=np.asarray(direct, np.float64),
        inputs=tuple(f"force {one} [N]" for one in inputs),
        outputs=tuple(f"{quantity} {one} [{SI_UNIT[quantity]}]" for one in outputs),
        unit=SI_UNIT[quantity],
        frequency_hz=np.abs(poles) / (2 * np.pi),
        frequency_sigma_hz=sigma[0],
        damping_ratio=-poles.real / np.abs(poles),
        damping_sigma=sigma[1],
    )


@dataclass(slots=True)
class SteppedModes:
    """Modes that go on from step to step under a force that runs straight between its samples.

    Attributes:
        state: (modes,) at the last sample; None at rest.
        force: N at the last sample.
    """

    state: Complex | None = None
    force: float = 0.0

    def step(self, poles: Complex, into: Complex, samples: Real, dt: float) -> Complex:
        """(modes, samples) states at the samples, the first one step after the last of the call before."""
        grows = np.exp(poles * dt)
        weights = np.array([ramp_weights(complex(p), dt) for p in poles])
        before, after = weights[:, 0] * into, weights[:, 1] * into
        found = np.empty((len(poles), samples.size), np.complex128)
        for k, newton in enumerate(samples):
            fed = 0.0 if self.state is None else grows * self.state + before * self.force + after * newton
            self.state = np.zeros(len(poles), np.complex128) + fed
            self.force, found[:, k] = float(newton), self.state
        return found
