"""Identification of an impact test: an estimator for the start, then maximum likelihood on the unfiltered blocks."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128
from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.progress import part_of_progress
from modallab.core.rig import Rig
from modallab.frf.estimate import group_by_point, impact_frf
from modallab.frf.sums import Estimator
from modallab.identification.estimate import PoleEstimate, estimate_poles, poles_without_stability
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.likelihood.frf_fit import left_by
from modallab.identification.likelihood.hit_blocks import Groups, HitBlocks, line_blocks
from modallab.identification.likelihood.hit_scatter import factors_by_scatter
from modallab.identification.likelihood.impact_search import first_look, fit_of_estimate, search_again
from modallab.identification.likelihood.search import NOT_SETTLED
from modallab.identification.model.modal_model import model_of_fit, with_hit_shares, without_sigma
from modallab.identification.options import IdentificationOptions
from modallab.identification.readings import floor_of_block, half_power_readings
from modallab.identification.selection.lost_modes import overlooked_poles
from modallab.identification.selection.operator_choice import chosen_modes, poles_to_search, start_poles
from modallab.identification.selection.pre_trigger_noise import model_error, model_error_notes
from modallab.identification.selection.prune import MODEL_ERROR_FROM, least_strength, strength_of_modes
from modallab.signals.block_sets import check_test
from modallab.signals.faults.whole_channels import LOWEST_LINE
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


LEAK = 300.0
"""The artificial damping lets every ring-down fall by this factor within the block, before an estimator sees it."""
ANTI_ALIAS_SHARE = 0.4
"""Up to this share of the rate the chain's anti-alias filters are flat."""
FORCE_DROP_DB = 40.0
"""Default upper edge: where the hit's spectrum has fallen by this much for good."""


def identify_impact(
    signals: Sequence[Signals], rig: Rig, options: IdentificationOptions
) -> tuple[ModalModel, LikelihoodFit]:
    """Modal model of the hits.

    Args:
        signals: blocks of the test, equal in rate and length, each with one hit.
        rig: channels and points.
        options: the estimator and whether its poles are refined; band and order.

    Raises:
        DataError: a block without a hit, or a band without lines.
        IdentificationError: the estimator finds no pole, or no pole stands out of the noise.
    """
    check_test(signals)
    groups = group_by_point(signals)
    band = options.band_hz or default_band(groups)
    frf = start_frf(groups, rig, band)
    estimate = estimate_poles(frf, options.method, options.max_order)
    poles = _start_poles(frf, estimate, band, options)
    unknown, notes = line_blocks(groups, rig, band)
    if not options.refined:
        fit = fit_of_estimate(unknown, poles, groups, band)
        keep = chosen_modes(fit, band, options, first=True)
        readings = _half_power_of_modes(fit, groups, rig, band, keep)
        rough = without_sigma(model_of_fit(fit, keep, rig, "impact", band, readings, notes, options.method))
        return with_hit_shares(rough, groups), fit
    found = HitSearch(unknown, groups, signals, band, options).found(frf, poles)
    fit, keep, ratio = found.fit, found.keep, found.misfit
    if not np.any(keep):
        raise IdentificationError(
            f"no mode stands out of the noise between {band[0]:.4g} and {band[1]:.4g} Hz",
            remedy="widen the band, hit harder, or check that the force and the sensors are connected",
        )
    if not fit.refined.settled:
        notes = (*notes, NOT_SETTLED)
    factors = factors_by_scatter(fit, ratio)
    notes = (*notes, *model_error_notes(ratio, widened=bool(np.any(factors[keep] > 1))))
    notes = (*notes, *_scatter_notes(factors[keep]))
    fit = replace(fit, by_scatter=factors)
    readings = _half_power_of_modes(fit, groups, rig, band, keep)
    model = model_of_fit(fit, keep, rig, "impact", band, readings, notes, options.method)
    return with_hit_shares(model, groups), fit


def _scatter_notes(factors: NDArray[np.float64]) -> tuple[str, ...]:
    """What is said where hits differ by more than noise."""
    most = float(factors.max(initial=1.0))
    if most <= 1:
        return ()
    return (
        f"The modes shift from hit to hit by up to {most:.2g} times what the noise explains, as with the temperature "
        "or a clamp that settles. The uncertainties of frequencies and damping ratios include that.",
    )


def _half_power_of_modes(
    fit: LikelihoodFit, groups: Groups, rig: Rig, band: tuple[float, float], keep: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    measured = impact_frf(groups, rig, band)
    found = np.sort(fit.point.parameters.omega[keep] / (2 * np.pi))
    return half_power_readings(measured, found), floor_of_block(fit, measured.frequency_hz, found)


def default_band(groups: Groups) -> tuple[float, float]:
    """From the third line to where the hits' spectrum has fallen by 40 dB for good, 0.4 of the rate at most."""
    first = groups[0][0]
    n, rate = first.force.size, first.rate_hz
    power = np.zeros(n // 2 + 1)
    for signals in (s for group in groups for s in group):
        power += np.abs(np.fft.rfft(signals.hit_force)) ** 2
    loud = np.flatnonzero(power > power.max() * 10 ** (-FORCE_DROP_DB / 10))
    return LOWEST_LINE * rate / n, min(ANTI_ALIAS_SHARE * rate, float(loud[-1]) * rate / n)


def start_frf(groups: Groups, rig: Rig, band_hz: tuple[float, float], estimator: Estimator = "H1") -> Frf:
    """The averaged FRFs that the estimators see: on Re s = sigma, where the block's end cuts nothing off.

    Raises:
        DataError: a block without a hit, a band without lines, or a point with one hit for H2 or Hv.
    """
    first = groups[0][0]
    shift = np.log(LEAK) / (first.force.size / first.rate_hz)
    return impact_frf(groups, rig, band_hz, estimator=estimator, damping_shift=float(shift))


def _start_poles(
    frf: Frf, estimate: PoleEstimate, band: tuple[float, float], options: IdentificationOptions
) -> NDArray[np.complex128]:
    found = start_poles(estimate.poles, estimate.orders, options)
    if not found.size and options.refined:
        found = poles_without_stability(frf, estimate)
    if not found.size:
        sought = (
            f"stable pole between {band[0]:.4g} and {band[1]:.4g} Hz up to order {estimate.orders[-1].order}"
            if (estimate.orders)
            else f"peak between {band[0]:.4g} and {band[1]:.4g} Hz"
        )
        raise IdentificationError(
            f"no {sought}", remedy="widen the band or look at the FRFs: is there a resonance in them at all?"
        )
    return found
