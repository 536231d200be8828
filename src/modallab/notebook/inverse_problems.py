"""The change that gives a required property: a frequency, a band without modes, an absorber."""

from collections.abc import Sequence

from modallab.modification.inverse import (
    BestAbsorber,
    By,
    ChangeAtPoint,
    FreeBand,
    best_absorber,
    changes_for_free_band,
    changes_for_frequency,
)
from modallab.modification.known import KnownStructure
from modallab.modification.structure import At
from modallab.notebook.display import DisplayedResult
from modallab.reporting.modification_table import absorber_rows, free_rows, tuned_rows


class ModelInverse:
    """The change that gives a required property; `known` is the structure."""

    __slots__ = ()

    @property
    def known_structure(self) -> KnownStructure:
        """The structure that the model describes."""
        raise NotImplementedError

    def tune(
        self, mode: int, to_hz: float, by: By, at: Sequence[At] | None = None
    ) -> DisplayedResult[tuple[ChangeAtPoint, ...]]:
        """The mass, or spring to ground, that moves a mode to a frequency, at each point: the smallest first.

        Args:
            mode: from 1.
            to_hz: Hz.
            by: "mass" or "spring".
            at: points to try; None for all that have a sensor.

        Raises:
            DataError: no such mode, a frequency beyond the band, or an unknown point.
        """
        found = changes_for_frequency(self.known_structure, mode, to_hz, by, at or self._sensors())
        return DisplayedResult(found, *tuned_rows(found, by, mode, to_hz))

    def free_band(
        self, band_hz: tuple[float, float], by: By, at: Sequence[At] | None = None
    ) -> DisplayedResult[tuple[FreeBand, ...]]:
        """The mass, or spring to ground, that leaves no mode in a band, at each point: the smallest first.

        Args:
            band_hz: lower and upper edge.
            by: "mass" or "spring".
            at: points to try; None for all that have a sensor.

        Raises:
            DataError: edges in the wrong order or outside the band of the model, or an unknown point.
        """
        found = changes_for_free_band(self.known_structure, band_hz, by, at or self._sensors())
        return DisplayedResult(found, *free_rows(found, by, band_hz))

    def best_absorber(self, mode: int, at: At, mass: float) -> DisplayedResult[BestAbsorber]:
        """The absorber of a given mass that makes the peak of the mobility of a mode at its point smallest.

        `modify` accepts `.numbers.absorber`.

        Args:
            mode: from 1.
            at: point of the absorber.
            mass: kg.

        Raises:
            DataError: no such mode, or a mode with a node there.
        """
        found = best_absorber(self.known_structure, mode, at, mass)
        return DisplayedResult(found, *absorber_rows(found, mode))

    def _sensors(self) -> list[At]:
        return list(self.known_structure.sensors)
