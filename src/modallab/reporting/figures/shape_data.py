"""Mode shapes made ready to be drawn: real, with one sign, along the beam."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from modallab.core.block import Block, Campaign
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.modification.deflection import shapes_at_freedoms, turn_to_real

_DRAWN_PLACES = 60
"""Of a smooth curve."""


@dataclass(frozen=True, eq=False, slots=True)
class BeamShape:
    """One mode shape along the beam.

    Attributes:
        x_m: (n,) places of sensors and forces, ascending.
        phi: (n,) real part at unit modal mass in kg^-1/2, after a turn of the phase that makes it as real as can be.
        quadrature: (n,) imaginary part after that turn: what moves a quarter of a period late.
        sigma: (n,) standard deviation, NaN where not known.
        skew_deg: mean angle, weighted by the squared amplitude, by which points move out of step.
    """

    x_m: NDArray[np.float64]
    phi: NDArray[np.float64]
    quadrature: NDArray[np.float64]
    sigma: NDArray[np.float64]
    skew_deg: float


def beam_shape(model: ModalModel, mode: int, rig: Rig) -> BeamShape | None:
    """One mode's shape, the point with the largest motion positive; None if shapes or places are not known."""
    shapes = shapes_at_freedoms(model, rig)
    if model.shapes is None or shapes is None:
        return None
    places = {p.id: p.x_m for p in rig.points}
    x = np.array([places.get(point, np.nan) for point, _ in shapes[0]])
    phi, sigma = np.asarray(shapes[1][mode]), shapes[2][mode]
    order = np.argsort(x, kind="stable")
    known = order[np.isfinite(x[order]) & np.isfinite(phi[order])]
    if known.size < 2:
        return None
    real = turn_to_real(phi[known])
    return BeamShape(x[known], real.real, real.imag, sigma[known], _skew_deg(real))


def smooth_curve(x_m: NDArray[np.float64], phi: NDArray[np.float64], clamped: bool) -> NDArray[np.float64]:
    """(2, places) smooth curve through the points, for the eye only; it starts at the clamp if there is one.

    No slope is forced at the clamp: whether it is rigid is a question, not a fact.
    """
    if clamped and x_m[0] > 0:
        x_m, phi = np.concatenate([[0.0], x_m]), np.concatenate([[0.0], phi])
    places, keep = np.unique(x_m, return_index=True)
    fine = np.linspace(places[0], places[-1], _DRAWN_PLACES)
    if places.size < 4:
        return np.array([fine, np.interp(fine, places, phi[keep])])
    return np.array([fine, CubicSpline(places, phi[keep], bc_type="not-a-knot")(fine)])


def _skew_deg(phi: NDArray[np.complex128]) -> float:
    weight = np.abs(phi) ** 2
    angle = np.arctan2(np.abs(phi.imag), np.abs(phi.real))
    return float(np.rad2deg((weight * angle).sum() / weight.sum())) if weight.sum() > 0 else 0.0


PAPER_SINE_HZ = 28 / 1.024
"""27.34 Hz, FFT line 28: the sine test the paper draws."""


def example_block(campaign: Campaign, test: Test) -> Block | None:
    """The block a figure shows: the sine block nearest to the paper's, or the first hit; None if there is none."""
    blocks = campaign.of(test)
    if test == "sine":
        blocks = tuple(b for b in blocks if b.frequency_hz is not None)
        return min(blocks, key=lambda b: abs((b.frequency_hz or 0) - PAPER_SINE_HZ), default=None)
    return blocks[0] if blocks else None


def farthest_sensor(rig: Rig, outputs: tuple[str, ...]) -> int:
    """Place among `outputs` of the sensor farthest from the clamp (the paper's point 10); the last if none has one."""
    x = [distance_from_clamp(rig, name) for name in outputs]
    known = [i for i, value in enumerate(x) if np.isfinite(value)]
    return max(known, key=lambda i: x[i]) if known else len(outputs) - 1


def distance_from_clamp(rig: Rig, output: str) -> float:
    """Distance of a channel from the clamp in m; NaN if its place is not known."""
    point = next((c.point for c in rig.channels if c.name == output), None)
    return float("nan") if point is None else rig.x_of(point)


def sensor_label(output: str, point: int | None) -> str:
    """How a sensor is called in a figure: by its point, else by its channel."""
    return f"Point {point}" if point is not None else f"Channel {output}"
