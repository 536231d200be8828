"""What a modal model says of the change that a wanted property needs: a frequency, a free band, an absorber."""

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
    """The change that a wanted property needs; `known` is the structure."""

    __slots__ = ()

    @property
    def known(self) -> KnownStructure:
        """The structure that the model describes."""
        raise NotImplementedError

    def tune(
        self, mode: int, to_hz: float, by: By, at: Sequence[At] | None = None
    ) -> DisplayedResult[tuple[ChangeAtPoint, ...]]:
        """The mass, or spring to ground, that brings a mode to a frequency, at each point: the smallest first.

        Args:
            mode: from 1.
            to_hz: Hz.
            by: "mass" or "spring".
            at: points to try; None for all that have a sensor.

        Raises:
            DataError: no such mode, a frequency beyond the band, or a point that the model does not know.
        """
        found = changes_for_frequency(self.known, mode, to_hz, by, at or self._sensors())
        return DisplayedResult(found, *tuned_rows(found, by, mode, to_hz))

    def keep_free(
        self, band_hz: tuple[float, float], by: By, at: Sequence[At] | None = None
    ) -> DisplayedResult[tuple[FreeBand, ...]]:
        """The mass, or spring to ground, that leaves no mode in a band, at each point: the smallest first.

        Args:
            band_hz: lower and upper edge.
            by: "mass" or "spring".
            at: points to try; None for all that have a sensor.

        Raises:
            DataError: edges that do not rise or lie beyond the model's band, or a point that the model does not know.
        """
        found = changes_for_free_band(self.known, band_hz, by, at or self._sensors())
        return DisplayedResult(found, *free_rows(found, by, band_hz))

    def best_absorber(self, mode: int, at: At, mass: float) -> DisplayedResult[BestAbsorber]:
        """The absorber of a mass that leaves the least peak of the mobility at its point about a mode.

        `.numbers.absorber` is what `modify` takes.

        Args:
            mode: from 1.
            at: where it hangs.
            mass: kg.

        Raises:
            DataError: no such mode, or it has a node there.
        """
        found = best_absorber(self.known, mode, at, mass)
        return DisplayedResult(found, *absorber_rows(found, mode))

    def _sensors(self) -> list[At]:
        return list(self.known.sensors)
