"""A finite-element model as matrices, with what its parameters change of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.formats.fem.matrices import modes_of, symmetric
from modallab.formats.fem.node_modes import NodeModes, Units, in_si

Whole = NDArray[np.int64]

DIRECTIONS = {"x": 1, "y": 2, "z": 3, "rx": 4, "ry": 5, "rz": 6}
STIFFNESS, MASS = "stiffness", "mass"
"""Factors on the whole matrices, which every model has."""


@dataclass(frozen=True, eq=False, slots=True)
class MatrixModel:
    """K = stiffness K0 + sum of p K_p and M likewise, of parameters p by name.

    Attributes:
        stiffness: (n, n) K0, dense or sparse; N/m in the units of the model.
        mass: (n, n) M0.
        freedoms: (n,) node and direction of each row: x, y, z, rx, ry, rz or 1 to 6.
        stiffness_slopes: parameter -> (n, n) what one unit of it adds to K.
        mass_slopes: parameter -> (n, n) what one unit of it adds to M.
        places: node -> x, y and z in the unit of the model; empty where nodes have the numbers of points.
        points: node of a point of the rig, where numbers and places do not say it.
        units: of length; mm goes with tonnes.
        title: what it is of.
    """

    stiffness: Any
    mass: Any
    freedoms: Sequence[tuple[int, str | int]]
    stiffness_slopes: Mapping[str, Any] = field(default_factory=dict[str, Any])
    mass_slopes: Mapping[str, Any] = field(default_factory=dict[str, Any])
    places: Mapping[int, tuple[float, float, float]] = field(default_factory=dict[int, tuple[float, float, float]])
    points: Mapping[int, int] = field(default_factory=dict[int, int])
    units: Units = "m"
    title: str = "matrices"

    def __post_init__(self) -> None:
        """Take the matrices as whole ones, once.

        Raises:
            DataError: one is not square, not finite, zero or not symmetric, or a parameter's has another size.
        """
        for name in ("stiffness", "mass"):
            whole = symmetric(getattr(self, name), name, self.title)
            by = {n: symmetric(a, n, self.title) for n, a in getattr(self, f"{name}_slopes").items()}
            for n, matrix in by.items():
                if matrix.shape != whole.shape:
                    raise DataError(
                        f"the matrix of {n} is {matrix.shape}, the {name} {whole.shape}",
                        where=self.title,
                        remedy="give all matrices over the same freedoms",
                    )
            object.__setattr__(self, name, whole)
            object.__setattr__(self, f"{name}_slopes", by)

    @property
    def names(self) -> tuple[str, ...]:
        """Of its parameters."""
        return tuple(dict.fromkeys((STIFFNESS, MASS, *self.stiffness_slopes, *self.mass_slopes)))

    def modes(self, numbers: Mapping[str, float]) -> NodeModes:
        """The lowest modes, in SI units.

        Args:
            numbers: parameter -> its value; the factors `stiffness` and `mass` are 1 if left out, all others 0.

        Raises:
            DataError: no such parameter, or matrices that do not belong together.
        """
        unknown = [name for name in numbers if name not in self.names]
        if unknown:
            raise DataError(
                f"the model has no parameter {unknown[0]!r}", where=self.title, remedy=f"use {', '.join(self.names)}"
            )
        k = _sum(self.stiffness, numbers.get(STIFFNESS, 1.0), self.stiffness_slopes, numbers)
        m = _sum(self.mass, numbers.get(MASS, 1.0), self.mass_slopes, numbers)
        return in_si(modes_of(k, m, self._rows, dict(self.places), self.title), self.units)

    @property
    def _rows(self) -> Whole:
        rows = [(node, DIRECTIONS.get(str(direction), direction)) for node, direction in self.freedoms]
        return np.array(rows, np.int64).reshape(-1, 2)


def _sum(whole: Any, factor: float, by: Mapping[str, Any], numbers: Mapping[str, float]) -> Any:
    return sum((numbers.get(name, 0.0) * matrix for name, matrix in by.items()), factor * whole)
