"""The search for the modes of hits: until every pole that is left is a mode, and no mode is left out."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128
from modallab.core.frf import Frf
from modallab.core.progress import part_of_progress
from modallab.identification.estimate import estimate_poles
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.frf_fit import left_by
from modallab.identification.likelihood.hit_blocks import Groups, HitBlocks
from modallab.identification.likelihood.impact_search import first_look, search_again
from modallab.identification.options import IdentificationOptions
from modallab.identification.selection.lost_modes import overlooked_poles
from modallab.identification.selection.operator_choice import chosen_modes, poles_to_search
from modallab.identification.selection.pre_trigger_noise import model_error
from modallab.identification.selection.prune import MODEL_ERROR_FROM, least_strength, strength_of_modes
from modallab.signals.signals import Signals


@dataclass(frozen=True, eq=False, slots=True)
class FoundModes:
    """End of a search: the fit, which of its poles (poles,) are modes, and its residual over the pre-trigger noise."""

    fit: LikelihoodFit
    keep: NDArray[np.bool_]
    misfit: float

    @property
    def poles(self) -> Complex128:
        """The modes' (modes,) rad/s."""
        at = self.fit.point.parameters
        return np.asarray(-at.zeta[self.keep] * at.omega[self.keep] + 1j * at.omega[self.keep], np.complex128)


@dataclass(frozen=True, eq=False, slots=True)
class HitSearch:
    """The hits of a test, and where their modes are looked for.

    Attributes:
        unknown: the blocks at their lines, with what each has to itself.
        groups: the hits by point.
        signals: all of them.
        band: of the lines, Hz.
        options: what the operator picks or drops.
    """

    unknown: HitBlocks
    groups: Groups
    signals: Sequence[Signals]
    band: tuple[float, float]
    options: IdentificationOptions

    def found(self, frf: Frf, poles: Complex128) -> FoundModes:
        """The modes from these start poles; where they leave more than noise, also those that show in what they leave.

        Args:
            frf: what was estimated from.
            poles: (poles,) rad/s, where the search begins.
        """
        first = self._from(poles)
        explained = first.misfit <= MODEL_ERROR_FROM
        if self._by_hand or explained or not np.any(first.keep):
            return first
        left = estimate_poles(left_by(frf, first.poles), self.options.method, self.options.max_order)
        more = overlooked_poles(frf, first.poles, left.orders, self.band)
        if not more.size:
            return first
        second = self._from(np.concatenate([first.poles, more]))
        return second if np.count_nonzero(second.keep) > np.count_nonzero(first.keep) else first

    @property
    def _by_hand(self) -> bool:
        return bool(self.options.pick_hz or self.options.drop_hz)

    def _from(self, poles: Complex128) -> FoundModes:
        with part_of_progress(0.0, 0.5, "first search"):
            fit = first_look(self.unknown, poles, self.groups, self.band)
        keep = chosen_modes(fit, self.band, self.options, first=True)
        with part_of_progress(0.5, 0.8, "search"):
            found = self._until_all_stand(fit, keep)
        with part_of_progress(0.8, 1.0, "poles that stand for errors"):
            return self._without_errors(found)

    def _until_all_stand(self, fit: LikelihoodFit, keep: NDArray[np.bool_]) -> FoundModes:
        """The fit of the kept poles, searched again while some turn out to be none: these share what others are.

        Where the operator has picked or dropped modes, it is searched once.
        """
        begun = 0
        while np.any(keep) and np.count_nonzero(keep) != begun:
            begun = np.count_nonzero(keep)
            fit = search_again(self.unknown, fit, poles_to_search(fit, keep, self.band, self.options), self.band)
            keep = chosen_modes(fit, self.band, self.options, first=False)
            if self._by_hand:
                break
        return FoundModes(fit, keep, model_error(fit, self.signals))

    def _without_errors(self, found: FoundModes) -> FoundModes:
        """The fit without poles that may stand for what is wrong with the model.

        Where the operator has picked or dropped modes, nothing more is taken away.
        """
        fit, keep = found.fit, found.keep
        doubtful = keep & (strength_of_modes(fit) < least_strength(fit, found.misfit))
        if self._by_hand or not np.any(doubtful) or np.array_equal(doubtful, keep):
            return found
        return self._until_all_stand(fit, keep & ~doubtful)
