"""Two models of one structure side by side: which modes are the same, and whether their shapes agree."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.identification.selection.criteria import comac, mac, nearest_partners


@dataclass(frozen=True, eq=False, slots=True)
class ShapeComparison:
    """Shapes of the modes that two models share, over the points that both have.

    Attributes:
        pairs: (pairs,) places of a mode in the one and in the other model.
        points: (points,) where both have a sensor.
        mac: (pairs,) MAC of the two shapes of a pair.
        comac: (points,) low where a point disagrees in many modes.
    """

    pairs: tuple[tuple[int, int], ...]
    points: tuple[int, ...]
    mac: Real
    comac: Real


def compare_shapes(one: ModalModel, other: ModalModel) -> ShapeComparison:
    """The shapes of the shared modes.

    Raises:
        DataError: fewer than two points are known to both, or no mode is shared.
    """
    points = _common_points(one, other)
    found = nearest_partners(one.frequency_hz, other.frequency_hz)
    pairs = tuple((i, j) for i, j in enumerate(found) if j is not None)
    if not pairs:
        raise DataError("the models share no mode", remedy="identify bands that overlap")
    a = _shapes_at_points(one, points)[[i for i, _ in pairs]]
    b = _shapes_at_points(other, points)[[j for _, j in pairs]]
    return ShapeComparison(pairs, points, np.diag(mac(a, b)).copy(), comac(a, b))


def common_shapes(one: ModalModel, other: ModalModel) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """(modes, points) of each over the points that both have, for a MAC; any scale.

    Raises:
        DataError: fewer than two points are known to both.
    """
    points = _common_points(one, other)
    return _shapes_at_points(one, points), _shapes_at_points(other, points)


def _common_points(one: ModalModel, other: ModalModel) -> tuple[int, ...]:
    points = tuple(sorted({p for p in one.output_points if p is not None} & set(other.output_points)))
    if len(points) < 2:
        raise DataError(
            f"the models share {len(points)} points", remedy="compare models of sensors at two known points at least"
        )
    return points


def _shapes_at_points(model: ModalModel, points: tuple[int, ...]) -> NDArray[np.complex128]:
    """(modes, points) modal constants of each mode's loudest input: they need no driving point."""
    size = np.sum(np.abs(model.modal_constants), axis=1)
    places = [model.output_points.index(p) for p in points]
    return np.stack([model.modal_constants[r, places, k] for r, k in enumerate(np.argmax(size, axis=1))])


@dataclass(frozen=True, eq=False, slots=True)
class ModelReduction:
    """The size of measured FRFs and of their model, and the error of each pair.

    Attributes:
        outputs: (outputs,) channel names.
        output_points: (outputs,) where they are; None where unknown.
        input_points: (inputs,) points that were driven; None where unknown.
        measured_numbers: real numbers in the measured FRFs.
        model_numbers: real numbers in the model: poles, modal constants, residual terms.
        error: (outputs, inputs) effective value of the difference, over that of the measured FRF.
        frac: (outputs, inputs) FRAC of measured against regenerated.
    """

    outputs: tuple[str, ...]
    output_points: tuple[int | None, ...]
    input_points: tuple[int | None, ...]
    measured_numbers: int
    model_numbers: int
    error: Real
    frac: Real


def reduction_of(model: ModalModel, measured: Complex, regenerated: Complex, frac: Real) -> ModelReduction:
    """The size before and after, and the error of each pair.

    Args:
        model: of the FRFs.
        measured: (outputs, inputs, lines).
        regenerated: the model's, through the same block.
        frac: (outputs, inputs) of one against the other.
    """
    off, size = (np.linalg.norm(one, axis=-1) for one in (regenerated - measured, measured))
    constants = 2 if np.any(model.modal_constants.imag) else 1
    return ModelReduction(
        model.outputs,
        model.output_points,
        model.input_points,
        2 * measured.size,
        2 * model.n_modes + constants * model.modal_constants.size + model.residuals.size,
        np.divide(off, size, out=np.full_like(size, np.nan), where=size > 0),
        frac,
    )
