"""The one objective: rows with noise and with a discrepancy of the model, one scale for each group of rows.

A row's residual follows Student's t distribution with variance sigma^2 + s_g^2 a^2: sigma its noise, a the size by
which the model may be off there, s_g the scale of its group. Each scale is set to its most probable value at every step
(automatic relevance determination: MacKay, Neural Computation 4, 1992, 415; model discrepancy: Kennedy and O'Hagan, J.
R. Stat. Soc. B 63, 2001, 425). A large scale says where the model is wrong.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.gap.inference.settings import Settings

Array = NDArray[np.float64]
Levels = NDArray[np.intp]
"""(groups,) index of the value of each group's scale."""


@dataclass(frozen=True, eq=False, slots=True)
class ObjectiveRows:
    """What was measured.

    Attributes:
        z: (rows,) measured.
        sigma: (rows,) standard deviation of the noise, in the unit of z; inf where a row is not to be used.
        size: (rows,) by how much the model may be off at a scale of 1, in the unit of z.
        group: (rows,) index of the group whose scale a row shares.
        names: of the groups.
    """

    z: Array
    sigma: Array
    size: Array
    group: NDArray[np.intp]
    names: tuple[str, ...]

    @classmethod
    def none(cls, names: tuple[str, ...]) -> "ObjectiveRows":
        """No rows of these groups."""
        nothing = np.zeros(0)
        return cls(nothing, nothing, nothing, np.zeros(0, np.intp), names)

    @classmethod
    def joined(cls, parts: "list[ObjectiveRows]") -> "ObjectiveRows":
        """ObjectiveRows one after another; their groups are those of the first that has any."""
        z, sigma, size, group = (
            np.concatenate([getattr(p, name) for p in parts]) for name in ("z", "sigma", "size", "group")
        )
        return cls(z, sigma, size, group, parts[0].names)


class ScaledObjective:
    """The objective of some rows, tabulated over the values of the scales."""

    def __init__(self, rows: ObjectiveRows, settings: Settings) -> None:
        """Tabulate the variances of these rows."""
        self.rows, self.nu, self.scales = rows, settings.degrees_of_freedom, settings.scale_values
        used = np.isfinite(rows.sigma)
        noise = np.where(used, rows.sigma, 1.0) ** 2
        variance = self.scales[:, None] ** 2 * np.where(used, rows.size, 0.0) ** 2 + noise
        self._order = np.argsort(rows.group, kind="stable")
        self._begins = np.searchsorted(rows.group[self._order], np.arange(len(rows.names) + 1))
        self._precision = np.where(used, 1 / variance, 0.0)
        self._logs = self._by_group(np.where(used, np.log(variance / noise), 0.0))

    def levels(self, residual: Array) -> Levels:
        """(groups,) the most probable scale of each group."""
        squares = (self.nu + 1) * np.log1p(self._precision * (residual**2 / self.nu))
        return np.argmin(self._by_group(squares) + self._logs, axis=0)

    def values(self, levels: Levels) -> Array:
        """(groups,) these scales as shares of the response."""
        return self.scales[levels]

    def precision(self, levels: Levels) -> Array:
        """(rows,) one over the variance of each row."""
        return self._precision[levels[self.rows.group], np.arange(len(self.rows.group))]

    def precisions(self, level: int, rows: NDArray[np.intp]) -> Array:
        """The same of some rows at one value of the scale."""
        return self._precision[level, rows]

    def weights(self, residual: Array, levels: Levels) -> Array:
        """(rows,) weights of least squares with the same slope (Lange, Little and Taylor, 1989)."""
        precision = self.precision(levels)
        return precision * (self.nu + 1) / (self.nu + precision * residual**2)

    def cost(self, residual: Array, levels: Levels) -> float:
        """-2 log of the density of these residuals, but for a constant."""
        squares = self.precision(levels) * residual**2
        density = (self.nu + 1) * np.sum(np.log1p(squares / self.nu))
        return float(density + np.sum(self._logs[levels, np.arange(len(levels))]))

    def _by_group(self, values: Array) -> Array:
        """(scales, groups) sums over the rows of each group."""
        cumulated = np.cumsum(np.pad(values[:, self._order], ((0, 0), (1, 0))), axis=1)
        return np.diff(cumulated[:, self._begins], axis=1)
