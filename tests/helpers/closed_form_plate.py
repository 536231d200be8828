"""A simply supported plate struck at every point, whose modes have a closed form."""

import numpy as np
from scipy.linalg import eigh

from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Point, Rig, Tolerance

A, B, MASS_KG = 0.5, 0.4, 2.0
X, Y = (v.ravel() for v in np.meshgrid(np.linspace(0.1, 0.9, 5) * A, np.linspace(0.15, 0.85, 4) * B, indexing="ij"))
ORDERS = ((1, 1), (2, 1), (1, 2), (2, 2))
OMEGA = 2 * np.pi * 20.0 * np.array([(m / A) ** 2 + (n / B) ** 2 for m, n in ORDERS]) / (1 / A**2 + 1 / B**2)
SENSORS = (1, 7, 14)


def shapes(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(modes, places) at unit modal mass."""
    each = [np.sin(m * np.pi * x / A) * np.sin(n * np.pi * y / B) for m, n in ORDERS]
    return 2 / np.sqrt(MASS_KG) * np.array(each)


def rig() -> Rig:
    points = tuple(Point(id=n + 1, x_m=x, y_m=y) for n, (x, y) in enumerate(zip(X.tolist(), Y.tolist(), strict=True)))
    force = Channel(index=0, name="force", quantity="force", unit="N")
    sensors = tuple(
        Channel(index=n + 1, name=f"a{n + 1}", quantity="acceleration", unit="m/s^2", point=p)
        for n, p in enumerate(SENSORS)
    )
    return Rig(name="plate", model="unknown", tolerance=Tolerance.usual(), points=points, channels=(force, *sensors))


def model(omega: np.ndarray, psi: np.ndarray, gains: tuple[float, ...] = (1.0, 1.0, 1.0)) -> ModalModel:
    """Of shapes (modes, points), struck at every point."""
    out = psi[:, [p - 1 for p in SENSORS]] * np.array(gains)
    constants = out[:, :, None] * psi[:, None, :]
    nothing, hz = np.full(omega.size, np.nan), omega / (2 * np.pi)
    return ModalModel(
        method="plscf", band_hz=(5.0, 1.2 * float(hz[-1])), frequency_hz=hz, damping_ratio=np.full(omega.size, 0.005),
        frequency_sigma_hz=nothing, damping_sigma=nothing, outputs=("a1", "a2", "a3"), output_points=SENSORS,
        input_points=tuple(range(1, X.size + 1)), modal_constants=constants.astype(complex),
        modal_constant_sigma=np.full(constants.shape, np.nan), residuals=np.zeros((0, 3, X.size)),
        half_power=nothing, half_power_floor=nothing,
    )  # fmt: skip


def with_mass(kg: float, x: float, y: float) -> ModalModel:
    """By the eigenproblem of the modes with the mass among them, which the diagnosis does not solve."""
    there = shapes(np.array([x]), np.array([y]))
    squared, turned = eigh(np.diag(OMEGA**2), np.eye(OMEGA.size) + kg * there @ there.T)
    return model(np.sqrt(squared), turned.T @ shapes(X, Y))


REFERENCE = model(OMEGA, shapes(X, Y))
