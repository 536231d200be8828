"""Where the gap lies, from tests on the residual alone: no effect is named here.

Harmonics under a sine and an FRF that depends on the level show a nonlinearity (Worden and Tomlinson, Nonlinearity in
Structural Dynamics, 2001, ch. 2). The factors common to all channels are linear least squares, line by line; a delay is
a phase in proportion to frequency.
"""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.digits import percent_text, relative_change, share_text, three_digits
from modallab.core.effects import Stage
from modallab.gap.conditioning.prepare import PreparedCampaign
from modallab.gap.conditioning.rows import Reduced, Rows
from modallab.gap.model.fit import Fit, Problem, all_rows, row_frequencies_hz
from modallab.gap.model.forward import forward
from modallab.gap.model.minimise import minimise
from modallab.gap.report.harmonics import OFTEN, harmonic_shares, levels_differ
from modallab.gap.search.channel_share import channel_share
from modallab.gap.search.fitting import COARSEST_ERROR, Bench, excess_over_floor
from modallab.twin.modes import solve_modes

CURES = 0.08
"""Leaving a channel out must bring the excess below this share for the gap to be that channel's."""
ALIKE = 0.15
"""Share of the gap that may stay for channels to count as off alike."""
SKEWS_S = (0.0, *np.geomspace(1e-6, 2e-4, 24).tolist())
"""Delays from row to row that are tried, s."""
ALONE = 1.4
"""Times the floor from which a test that is fitted alone disagrees with every beam."""
CLOCK = 1e-4
"""Relative error of the sines' frequency that no generator has."""
LATE = 0.45
"""Share of the common phase that a delay must make."""
POLE_SHIFT = 6e-4
"""Relative spread of the poles about the best beam that is more than a beam's tolerance."""


@dataclass(frozen=True, slots=True)
class ResidualTestsResult:
    """Where, and why there."""

    stage: Stage
    channels: tuple[int, ...]
    tests: tuple[str, ...]
    why: tuple[str, ...]
    nonlinear: bool = False


def locate_gap(bench: Bench, prepared: PreparedCampaign, base: Fit) -> ResidualTestsResult:
    """Stage, channels and tests of the gap a baseline fit leaves."""
    tests = _tests_of_data(bench.data)
    alone, cured = _channel_alone(bench, base)
    if alone:
        held = [c for c in alone if c in prepared.repeated]
        names = ", ".join(bench.data.rig.channels[c].name for c in alone)
        if held:
            return ResidualTestsResult(
                "acquisition", alone, tests, (f"{names} repeats samples exactly, which no motion does.",)
            )
        return ResidualTestsResult(
            "sensor", alone, tests, (f"Without {names} {share_text(1 - cured)} of the gap disappears.",)
        )
    harmonic, driven = harmonic_shares(prepared)
    if driven > OFTEN:
        return ResidualTestsResult("excitation", (), ("sine",), ("The force itself contains overtones of the drive.",))
    if harmonic > OFTEN:
        why = f"{percent_text(harmonic)} of the sine responses contain overtones that the force lacks."
        sentences = (why, "The response does not grow in proportion to the force: the nonlinearity lies in the beam.")
        return ResidualTestsResult("structure", (), tests, sentences, nonlinear=True)
    return _locate_in_beam_or_test(bench, base, tests)


def _locate_in_beam_or_test(bench: Bench, base: Fit, tests: tuple[str, ...]) -> ResidualTestsResult:
    """The beam if its poles or its levels say so, a test if only that one disagrees, else the chain of all channels."""
    shift = rms_shift_of_poles(bench, base)
    by_test = {t: excess_over_floor(_gap_on_test(bench, base, t)) for t in tests} if len(tests) > 1 else {}
    why = [f"The poles of the ring-down lie {percent_text(shift)} (rms) off those of the best beam."]
    if by_test:
        why.append(
            "Fitted alone: "
            + ", ".join(f"{t} {three_digits(float(np.sqrt(1 + by_test[t])))}" for t in tests)
            + " noise units."
        )
    levels = levels_differ(base)
    if by_test and shift < POLE_SHIFT:
        bad = tuple(t for t in tests if np.sqrt(1 + by_test[t]) > ALONE * bench.flat + 1e-3 * base.gap)
        if not bad:
            return ResidualTestsResult(
                "excitation", (), ("sine",), (*why, "Each test agrees with a beam, but the two beams differ.")
            )
        if len(bad) == 1 and not (levels and bad == ("sine",)):
            return ResidualTestsResult(
                "excitation", (), bad, (*why, f"Only the {bad[0]} test disagrees, but its poles agree.")
            )
    if levels:
        sentences = (*why, "The two levels of the sine test disagree with each other.")
        return ResidualTestsResult("structure", (), tests, sentences, nonlinear=True)
    if shift >= POLE_SHIFT:
        return ResidualTestsResult("structure", (), tests, (*why, "No beam within its tolerances has such poles."))
    return _locate_in_chain(bench, base, tests, why)


def _locate_in_chain(bench: Bench, base: Fit, tests: tuple[str, ...], why: list[str]) -> ResidualTestsResult:
    """The chain of all channels, if they are off alike: its clock and its delays, or what is sensed."""
    common, flat = share_left_by_common_factors(base)
    everywhere = bench.data.channels
    if common > ALIKE:
        reason = (
            f"The poles are a beam's, but on a line the channels are not off alike: {percent_text(common)} of the "
            "gap stays."
        )
        return ResidualTestsResult("structure", (), tests, (*why, reason))
    sines = bench.data.sines
    if sines is not None and abs(sines.ratio - 1) > CLOCK:
        reason = (
            f"The generator's lines stand {relative_change(sines.ratio - 1)} off the set frequency: a clock is wrong."
        )
        return ResidualTestsResult("acquisition", everywhere, tests, (*why, reason))
    if flat < ALIKE:
        force = bench.data.rig.force_channel.index
        removed = share_text(1 - flat)
        reason = f"One real factor on all channels and lines removes {removed} of the gap: the gain of the force."
        return ResidualTestsResult("sensor", (force,), tests, (*why, reason))
    late = share_explained_by_delay(base)
    if late > LATE:
        reason = (
            f"All channels are off alike, and {percent_text(late)} of their phase error grows with frequency: a delay."
        )
        return ResidualTestsResult("acquisition", everywhere, tests, (*why, reason))
    reason = (
        "The poles are those of a beam, all channels are off alike, but not by a delay: their common input is wrong."
    )
    return ResidualTestsResult("sensor", everywhere, tests, (*why, reason))


def share_explained_by_delay(base: Fit) -> float:
    """Share of the squares of the channels' common phase on the lines that a delay makes, 0 to 1.

    The coefficient of determination of a regression of phase on frequency through 0, weighted by the response.
    """
    seen, y, hz = _gap_in_noise_units(base)
    weight = np.sum(np.abs(y) ** 2, axis=0)
    factor = np.sum(y.conj() * seen, axis=0) / np.maximum(weight, 1e-300)
    usable = (np.abs(hz) > 1) & (np.abs(factor) > 0.3) & (np.abs(factor) < 3)
    weight = np.minimum(weight, np.quantile(weight, 0.9))[usable]
    phase, f = np.angle(factor[usable]) * np.sign(hz[usable]), np.abs(hz[usable])
    whole = float(np.sum(weight * phase**2))
    return float(np.sum(weight * phase * f)) ** 2 / max(whole * float(np.sum(weight * f**2)), 1e-300)


def _gap_in_noise_units(base: Fit) -> tuple[Complex, Complex, Real]:
    """(channels, lines) measured and predicted in noise units, and (lines,) Hz, all parts of the data side by side."""
    data = base.problem.data
    rows, answers = all_rows(data), forward(base.problem.twin(base.u), data)
    y = np.concatenate([a / r.sigma for a, r in zip(answers, rows, strict=True)], axis=1)
    seen = np.concatenate([r.y / r.sigma for r in rows], axis=1)
    return seen, y, np.concatenate(row_frequencies_hz(data))


def share_left_by_common_factors(base: Fit) -> tuple[float, float]:
    """Share of the gap that stays once all channels of a line may be off alike, and once all lines are too.

    The first allows a factor of its own on each line and a delay that grows from row to row, as a chain does; the
    second one real factor in all, as the force's sensitivity does.
    """
    seen, y, hz = _gap_in_noise_units(base)
    floor = 2 * np.count_nonzero(seen)
    turn = 2j * np.pi * hz * np.array(base.problem.data.channels)[:, None]
    whole = max(float(np.sum(np.abs(seen - y) ** 2)) - floor, 1e-9)
    left = min(_gap_by_line(seen, y * np.exp(turn * skew)) for skew in SKEWS_S)
    factor = float(np.real(np.vdot(y, seen))) / max(float(np.sum(np.abs(y) ** 2)), 1e-300)
    one = float(np.sum(np.abs(seen - factor * y) ** 2))
    return max(left - floor, 0.0) / whole, max(one - floor, 0.0) / whole


def _gap_by_line(seen: Complex, y: Complex) -> float:
    factors = np.sum(y.conj() * seen, axis=0) / np.maximum(np.sum(np.abs(y) ** 2, axis=0), 1e-300)
    return float(np.sum(np.abs(seen - factors * y) ** 2))


def rms_shift_of_poles(bench: Bench, base: Fit) -> float:
    """Rms relative distance of the ring-down's poles from the baseline's, one common factor taken out."""
    if len(bench.poles) < 2:
        return 0.0
    model = np.abs(solve_modes(base.problem.twin(base.u).structure).poles)
    seen = np.abs(bench.poles)
    gaps = np.array([np.log(s) - np.log(model[np.argmin(np.abs(np.log(model / s)))]) for s in seen])
    gaps = gaps[np.abs(gaps) < 0.3]
    return float(np.sqrt(np.mean((gaps - np.median(gaps)) ** 2))) if len(gaps) > 1 else 0.0


def _tests_of_data(data: Reduced) -> tuple[str, ...]:
    return (*dict.fromkeys(d.piece.test for d in data.impacts), *(("sine",) if data.sines is not None else ()))


def _channel_alone(bench: Bench, base: Fit) -> tuple[tuple[int, ...], float]:
    order = np.argsort(channel_share(base))[::-1]
    for count in (1, 2):
        chosen = [int(i) for i in order[:count]]
        data = replace(
            bench.thin,
            impacts=tuple(replace(d, rows=_keep_channels(d.rows, chosen)) for d in bench.thin.impacts),
            sines=replace(bench.thin.sines, rows=_keep_channels(bench.thin.sines.rows, chosen))
            if bench.thin.sines
            else None,
        )
        left = excess_over_floor(_fit_part_afresh(bench, data, base)) / excess_over_floor(base)
        if left < CURES:
            return tuple(sorted(bench.data.channels[i] for i in chosen)), left
    return (), 1.0


def _keep_channels(rows: Rows, channels: list[int]) -> Rows:
    sigma = rows.sigma.copy()
    sigma[channels] = np.inf
    return replace(rows, sigma=sigma)


def _gap_on_test(bench: Bench, base: Fit, test: str) -> Fit:
    data = replace(
        bench.thin,
        impacts=tuple(d for d in bench.thin.impacts if d.piece.test == test),
        sines=bench.thin.sines if test == "sine" else None,
    )
    return _fit_part_afresh(bench, data, base)


def _fit_part_afresh(bench: Bench, data: Reduced, base: Fit) -> Fit:
    """A baseline on part of the data, far enough from the old one to forget what the rest had done to it."""
    u = base.u[: bench.free.size]
    for floor in (COARSEST_ERROR, COARSEST_ERROR / 6, COARSEST_ERROR / 36):
        u = minimise(Problem(data, bench.free, (), floor), u, 2, 1e-2).u
    return minimise(Problem(data, bench.free, ()), u, 4, 1e-2)
