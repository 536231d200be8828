"""A frame of four floors, each moving along x, stiff columns between them; struck at the lowest."""

import numpy as np
from scipy.linalg import eigh

from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Point, Rig, Tolerance
from modallab.identification.frf_model import identify_frf
from modallab.identification.options import IdentificationOptions
from modallab.modification.freedoms import with_points

FLOORS = 4
MASSES = np.array([8.0, 6.5, 6.5, 6.5])
COLUMNS = 3.6e5
"""Stiffness between two floors, N/m."""
ROLLERS, CLAMPS = 5e2, COLUMNS
"""Stiffness beneath the lowest floor, N/m."""
ZETA = np.array([0.02, 0.012, 0.008, 0.007])


def rig() -> Rig:
    points = tuple(Point(id=n + 1, x_m=0.0, z_m=0.177 * n) for n in range(FLOORS))
    force = Channel(index=0, name="force", quantity="force", unit="N", point=1, direction="+x")
    sensors = tuple(
        Channel(index=n, name=f"a{n}", quantity="acceleration", unit="m/s^2", point=n, direction="+x")
        for n in range(1, FLOORS + 1)
    )
    return Rig(
        name="frame",
        model="unknown",
        tolerance=Tolerance.usual(),
        points=points,
        channels=(force, *sensors),
        drive_direction="+x",
    )


def frf(seed: int, beneath: float, lost: tuple[int, float] = (0, 0.0), noise: float = 1e-3) -> Frf:
    """FRFs with noise; column `lost[0]` (0 is beneath the lowest floor) has lost `lost[1]` N/m."""
    rng, k = np.random.default_rng(seed), np.array([beneath, *[COLUMNS] * (FLOORS - 1)])
    k[lost[0]] -= lost[1]
    stiffness = np.diag(k + np.append(k[1:], 0.0)) - np.diag(k[1:], 1) - np.diag(k[1:], -1)
    squared, shapes = eigh(stiffness, np.diag(MASSES))
    hz = np.arange(10.0, 150.0, 0.125)
    s = 2j * np.pi * hz[:, None]
    kernels = 1 / (s**2 + 2 * ZETA * np.sqrt(squared) * s + squared)
    values = np.einsum("or,lr,r->ol", shapes, kernels, shapes[0])[:, None] * s[:, 0] ** 2
    sigma = noise * float(np.sqrt(np.mean(np.abs(values) ** 2)))
    values = values + sigma / np.sqrt(2) * (rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape))
    points = tuple(range(1, FLOORS + 1))
    names = tuple(f"a{n}" for n in points)
    return Frf(hz, values, "inertance", names, points, (1,), variance=np.full(values.shape, sigma**2))


def model(of: Frf) -> ModalModel:
    return with_points(identify_frf(of, rig(), IdentificationOptions())[0], rig())
