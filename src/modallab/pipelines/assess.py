"""The assumptions of a test, judged on its own records."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError, ModallabError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.frf.broadband import PERIODIC, blocks_of_one_level, broadband_frf
from modallab.frf.estimate import impact_frf
from modallab.frf.joined import fewest_blocks, split_blocks
from modallab.frf.periodic_drive import without_decays
from modallab.frf.stepped import stepped_frf
from modallab.identification.impact import LEAK
from modallab.identification.likelihood.basis import poles_of
from modallab.identification.likelihood.fit import LikelihoodFit
from modallab.identification.model.modal_mass import driving_points
from modallab.identification.selection.assumptions import (
    CHANGE_LIMIT,
    SIGMAS,
    AllowedDifference,
    AssumptionVerdict,
    driving_point,
    linearity,
    linearity_of_waves,
    proportional_damping,
    reciprocity,
    time_invariance,
)
from modallab.identification.selection.pre_trigger_noise import model_error, pre_trigger_noise
from modallab.identification.selection.prune import confidence_of_strength, least_strength, strength_of_modes
from modallab.pipelines.averaged_frfs import distortions_of
from modallab.pipelines.levels import FORCE_RATIO, Groups, group_by_level, group_by_strength
from modallab.signals.signals import Signals
from modallab.verification.assessment import ModelAssessment, assess_model

Judge = tuple[str, Callable[[], AssumptionVerdict]]
LOUD = 0.01


def assess_impact(model: ModalModel, fit: LikelihoodFit, groups: Groups, rig: Rig) -> ModelAssessment:
    """Verdicts on the hits: hard against soft, first against last, point against point."""

    # On Re s = sigma, where the block's end cuts nothing off: two hits a sample apart would else seem to differ.
    shift = float(np.log(LEAK) * groups[0][0].rate_hz / groups[0][0].force.size)

    band = _loud_band(groups, model.band_hz)
    flat = [s for group in groups for s in group]
    # The fit's residual holds the very change that is looked for; the samples before the hits do not.
    before = pre_trigger_noise(flat)
    noise = fit.point.noise if before is None else before

    def frf(chosen: Groups) -> Frf:
        return _with_noise(impact_frf(chosen, rig, band, damping_shift=shift), noise, chosen)

    def both(choose: Callable[[Groups], tuple[Groups, Groups]]) -> tuple[Frf, Frf]:
        one, other = choose(groups)
        return frf(one), frf(other)

    by_hits, by_places = allowed_differences(rig, band[1])
    judges: list[Judge] = [
        ("linearity", lambda: linearity(*both(_softest_and_hardest), by_hits)),
        ("time invariance", lambda: time_invariance(*both(_first_and_last), by_hits)),
        ("reciprocity", lambda: reciprocity(_frf_along_drive(frf(groups), rig), by_places)),
        ("driving point", lambda: driving_point(_frf_along_drive(frf(groups), rig))),
    ]
    least = least_strength(fit, model_error(fit, flat))
    return _assess_model(model, fit, judges, least)


def allowed_differences(rig: Rig, hz: float) -> tuple[AllowedDifference, AllowedDifference]:
    """What the rig's tolerances allow two FRFs to differ by: of other hits at the same points; of points exchanged.

    Where a bending wave passes, a place that is off by d changes the motion by up to k d, k its wave number:
    k^4 = omega^2 rho A / EI (Cremer, Heckl and Petersson, Structure-Borne Sound, 2005, ch. 3).

    Args:
        rig: with its tolerances.
        hz: highest frequency that counts.
    """
    t, beam = rig.tolerance, rig.beam
    if beam is None:
        return AllowedDifference(), AllowedDifference()
    k = (2 * np.pi * hz) ** 0.5 * (beam.mass_kg / beam.length_m / beam.bending_stiffness_n_m2) ** 0.25
    hit = np.hypot(k * t.hit_position_m, t.hit_gain)
    sensor = np.hypot(k * t.position_m, t.sensitivity if t.of_assembly else 0.0)
    reason = f"as hits may land {1e3 * t.hit_position_m:g} mm off" if t.hit_position_m else "by the rig's tolerances"
    of_two = SIGMAS * np.sqrt(2) * np.array([hit, np.hypot(hit, sensor)])
    one, other = (
        AllowedDifference(float(share), reason) if share > CHANGE_LIMIT else AllowedDifference() for share in of_two
    )
    return one, other


def assess_sine(model: ModalModel, fit: LikelihoodFit, signals: Sequence[Signals], rig: Rig) -> ModelAssessment:
    """Verdicts on the sine blocks: level against level, and the driving point."""
    judges: list[Judge] = [
        ("linearity", lambda: linearity(*_frfs_by_level(signals, rig))),
        ("time invariance", _not_in_this_test("every frequency is driven only once at each level")),
        ("reciprocity", _not_in_this_test("a sine test drives one point")),
        ("driving point", lambda: driving_point(_frf_along_drive(stepped_frf(signals, rig), rig))),
    ]
    return _assess_model(model, fit, judges, least_strength(fit, float("nan")))


def assess_broadband(
    model: ModalModel, fit: LikelihoodFit, signals: Sequence[Signals], frf: Frf, rig: Rig
) -> ModelAssessment:
    """Verdicts on broadband blocks: level against level, the first half against the second, and the driving point."""
    band = model.band_hz
    ordered = blocks_of_one_level(sorted(signals, key=lambda s: s.block.order))
    if ordered[0].block.test in PERIODIC:
        # What still fades from the start of a wave is no change of the structure.
        poles = poles_of(2 * np.pi * model.frequency_hz, model.damping_ratio)
        ordered = without_decays(ordered, poles, band)

    def halves() -> tuple[Frf, Frf]:
        least = max(2, fewest_blocks(ordered, "H1"))
        if len(ordered) // 2 < least:
            raise DataError(f"there are {len(ordered)} blocks", remedy=f"record at least {2 * least}")
        one, other = (broadband_frf(half, rig, band, ordered) for half in split_blocks(ordered, 2))
        return one, other

    def levels() -> tuple[Frf, Frf]:
        (_, one), *_, (_, other) = group_by_level(signals)
        return broadband_frf(one, rig, band, signals), broadband_frf(other, rig, band, signals)

    def linear() -> AssumptionVerdict:
        # Levels show what depends on the amplitude, several waves what has other frequencies than the drive.
        if len({s.block.level for s in signals}) > 1:
            return linearity(*levels())
        return linearity_of_waves(distortions_of(ordered, model))

    judges: list[Judge] = [
        ("linearity", linear),
        ("time invariance", lambda: time_invariance(*halves())),
        ("reciprocity", _reciprocity_verdict(_frf_along_drive(frf, rig))),
        ("driving point", lambda: driving_point(_frf_along_drive(frf, rig))),
    ]
    return _assess_model(model, fit, judges, least_strength(fit, float("nan")))


def _reciprocity_verdict(frf: Frf) -> Callable[[], AssumptionVerdict]:
    if len(frf.input_points) == 1:
        return _not_in_this_test("one shaker drives one point")
    return lambda: reciprocity(frf)


def _frf_along_drive(frf: Frf, rig: Rig) -> Frf:
    """The FRF with a point only for what moves along the drive: nothing else shows a driving point."""
    return replace(frf, output_points=driving_points(rig))


def assess_frf(model: ModalModel, fit: LikelihoodFit, frf: Frf) -> ModelAssessment:
    """Verdicts on FRFs that came as such."""
    judges: list[Judge] = [
        ("linearity", _not_in_this_test("the FRFs have only one level")),
        ("time invariance", _not_in_this_test("the FRFs have no time order")),
        ("reciprocity", lambda: reciprocity(frf)),
        ("driving point", lambda: driving_point(frf)),
    ]
    return _assess_model(model, fit, judges, least_strength(fit, float("nan")))


def _assess_model(model: ModalModel, fit: LikelihoodFit, judges: Sequence[Judge], least: float) -> ModelAssessment:
    verdicts: list[AssumptionVerdict] = []
    unjudged: list[tuple[str, str]] = []
    for name, judge in (*judges, ("proportional damping", lambda: proportional_damping(model))):
        try:
            verdicts.append(judge())
        except ModallabError as error:
            unjudged.append((name, str(error)))
    omega = fit.point.parameters.omega / (2 * np.pi)
    place = [int(np.argmin(np.abs(omega - f))) for f in model.frequency_hz]
    return assess_model(
        model, tuple(verdicts), tuple(unjudged), confidence_of_strength(strength_of_modes(fit)[place], least)
    )


def _not_in_this_test(why: str) -> Callable[[], AssumptionVerdict]:
    def judge() -> AssumptionVerdict:
        raise DataError(why)

    return judge


def _loud_band(groups: Groups, band_hz: tuple[float, float]) -> tuple[float, float]:
    """The band up to where the weakest of the hits has fallen by 20 dB: beyond, one hit alone says little."""
    top = band_hz[1]
    for signals in (s for group in groups for s in group):
        power = np.abs(np.fft.rfft(signals.hit_force)) ** 2
        weak = np.flatnonzero(power < LOUD * power.max()) * signals.rate_hz / signals.force.size
        top = min(top, float(weak[weak > 2 * band_hz[0]].min(initial=top)))
    return band_hz[0], top


def _softest_and_hardest(groups: Groups) -> tuple[Groups, Groups]:
    levels = group_by_strength(groups)
    if not levels:
        found = f"no two hits at one point differ by more than {FORCE_RATIO:g} in force"
        raise DataError(found, remedy="add soft and hard hits")
    return levels[0][1], levels[-1][1]


def _first_and_last(groups: Groups) -> tuple[Groups, Groups]:
    several = [sorted(g, key=lambda s: s.block.order) for g in groups if len(g) > 1]
    if not several:
        raise DataError("every point was hit once", remedy="hit a point again at the end of the test")
    return [g[:1] for g in several], [g[-1:] for g in several]


def _with_noise(frf: Frf, noise: NDArray[np.float64], groups: Groups) -> Frf:
    """The FRF with the variance that the responses' noise gives it: H1 of K hits has 2 noise^2 / sum |F|^2."""
    first = groups[0][0]
    n, rate = first.force.size, first.rate_hz
    place = np.round(frf.frequency_hz * n / rate).astype(int)
    window = np.exp(-frf.damping_shift * np.arange(n) / rate)
    power = [sum(np.abs(np.fft.rfft(window * s.hit_force)[place]) ** 2 for s in group) for group in groups]
    variance = 2 * noise**2 * np.mean(window**2)
    return replace(frf, variance=variance[:, None, None] / np.stack(power)[None])


def _frfs_by_level(signals: Sequence[Signals], rig: Rig) -> tuple[Frf, Frf]:
    levels = sorted({s.block.level for s in signals if s.block.level is not None})
    if len(levels) != 2:
        raise DataError(f"the blocks are of {len(levels)} drive levels", remedy="drive at two")
    by_level = [{s.block.frequency_hz: s for s in signals if s.block.level == level} for level in levels]
    shared = sorted(f for f in by_level[0] if f is not None and f in by_level[1])
    if len(shared) < 4:
        raise DataError(
            f"{len(shared)} frequencies were driven at both levels", remedy="drive the same frequencies at both levels"
        )
    one, other = (stepped_frf([of[f] for f in shared], rig) for of in by_level)
    return one, replace(other, frequency_hz=one.frequency_hz)
