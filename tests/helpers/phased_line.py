"""Three modes seen by three sensors in a line and driven at the first; every constant turned by one common phase."""

import numpy as np
from scipy.linalg import eigh

from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Point, Rig, Tolerance

PSI = np.array([[0.20, 0.07, -0.18], [0.22, -0.24, 0.22], [0.15, -0.4, 0.36]])
"""(modes, points) at unit modal mass."""
OMEGA = 2 * np.pi * np.array([21.4, 50.0, 68.3])
ZETA = np.array([0.028, 0.0052, 0.0043])


def rig() -> Rig:
    points = tuple(Point(id=n + 1, x_m=0.3 * n) for n in range(3))
    force = Channel(index=0, name="force", quantity="force", unit="N", point=1)
    sensors = tuple(Channel(index=n, name=f"a{n}", quantity="acceleration", unit="m/s^2", point=n) for n in (1, 2, 3))
    return Rig(name="line", model="unknown", tolerance=Tolerance.usual(), points=points, channels=(force, *sensors))


def model(
    psi: np.ndarray = PSI,
    omega: np.ndarray = OMEGA,
    degrees: float = 0.0,
    zeta: np.ndarray = ZETA,
    sensors: tuple[int, ...] = (1, 2, 3),
    driven: tuple[int, ...] = (1,),
    twist: np.ndarray | None = None,
) -> ModalModel:
    """Of shapes (modes, points); `twist` (modes, points) rad turns each of them by itself."""
    psi = psi * np.exp(1j * (np.zeros(psi.shape) if twist is None else twist))
    out, into = psi[:, [p - 1 for p in sensors]], psi[:, [p - 1 for p in driven]]
    constants = out[:, :, None] * into[:, None, :] * np.exp(-1j * np.radians(degrees))
    nothing, hz = np.full(omega.size, np.nan), omega / (2 * np.pi)
    return ModalModel(
        method="plscf", band_hz=(10.0, 95.0), frequency_hz=hz, damping_ratio=zeta, frequency_sigma_hz=1e-5 * hz,
        damping_sigma=0.002 * zeta, outputs=tuple(f"a{p}" for p in sensors), output_points=sensors, input_points=driven,
        modal_constants=constants, modal_constant_sigma=np.full(constants.shape, np.nan),
        residuals=np.zeros((0, *constants.shape[1:])), half_power=nothing, half_power_floor=nothing,
    )  # fmt: skip


def with_mass(
    kg: float, point: int, degrees: float = 0.0, sensors: tuple[int, ...] = (1, 2, 3), driven: tuple[int, ...] = (1,)
) -> ModalModel:
    """By the eigenproblem of the modes with the mass among them; damping ratios stay."""
    there = PSI[:, [point - 1]]
    squared, turned = eigh(np.diag(OMEGA**2), np.eye(OMEGA.size) + kg * there @ there.T)
    return model(turned.T @ PSI, np.sqrt(squared), degrees, sensors=sensors, driven=driven)
