"""Identification of an impact test: pLSCF for the start, maximum likelihood on the unfiltered blocks for the end."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.errors import IdentificationError
from modallab.identification.basis import LineBlock
from modallab.identification.beyond import StartPoles, with_stand_ins
from modallab.identification.choice import chosen, start_poles
from modallab.identification.confidence import MODEL_ERROR_FROM, least_strength, strength
from modallab.identification.excitation import BlowExcitation, Grid
from modallab.identification.fit import Fit
from modallab.identification.half_power import reading_near, summed_amplitude
from modallab.identification.leftover import LEAST, leftover_sigma
from modallab.identification.model_of_fit import model_of_fit
from modallab.identification.options import Options
from modallab.identification.plscf import plscf
from modallab.identification.projection import Parameters, Problem
from modallab.identification.search import FIRST_LOOK, MAX_ITERATIONS, search
from modallab.identification.stabilisation import stable_poles
from modallab.schema.block import Signals
from modallab.schema.frf import DERIVATIVES
from modallab.schema.model import ModalModel
from modallab.schema.rig import Rig
from modallab.spectra.blow import Blow, find_blow, windowed_force
from modallab.spectra.border import check_test
from modallab.spectra.frf import convert, group_by_point, impact_frf, lines, output_quantity, quiet_level

LEAK = 300.0
"""The artificial damping lets every ring-down fall by this factor within the block, before pLSCF sees it."""
LOWEST_LINE = 3
"""Default lower edge: below it stand drift and the rest of the mean."""
ANTI_ALIAS_SHARE = 0.4
"""Up to this share of the rate the chain's anti-alias filters are flat."""
FORCE_DROP_DB = 40.0
"""Default upper edge: where the blow's spectrum has fallen by this much for good."""
STAND_INS = (1.05,)
"""A pole that begins at this multiple of the upper edge stands for the modes above."""
RESIDUAL_POWERS = (-2, 0, 2, 4)
"""Powers of s for what modes outside the band leave. -2 in a receptance is an acceleration like the force itself: modes
far above, sampled too slowly, leave some of it, and so does cross-talk. Left out, it passes for damping of the lowest
mode."""
MOST_FORCE_SAMPLES = 1500
"""More unknown force samples than these, over all blocks, take too long."""
SILENCE_NEEDED = 1000
"""Samples before the blows, over all outputs and blocks, that tell the noise to some 2 %."""
COLUMNS = 120
"""Default order: this many polynomial columns, shared among the inputs."""

Groups = Sequence[Sequence[Signals]]


def identify_impact(signals: Sequence[Signals], rig: Rig, options: Options) -> tuple[ModalModel, Fit]:
    """Modal model of the hits.

    Args:
        signals: blocks of the test, equal in rate and length, each with one blow.
        rig: channels and points.
        options: method "plscf"; band and order.

    Raises:
        DataError: a block without a blow, or a band without lines.
        IdentificationError: no stable pole.
    """
    check_test(signals)
    groups = group_by_point(signals)
    band = options.band_hz or default_band(groups)
    poles = _start_poles(groups, rig, band, options)
    unknown, notes = line_blocks(groups, rig, band)
    fit = _refined(unknown, poles, groups, band, FIRST_LOOK)
    keep = chosen(fit, band, options, first=True)
    if np.any(keep) and (unknown.at_rest or not (np.sum(keep) == poles.size and fit.refined.settled)):
        fit = _again(unknown, fit, keep, band)
        keep = chosen(fit, band, options, first=False)
    fit, keep, ratio = _without_errors(unknown, fit, keep, signals, band, options)
    if not np.any(keep):
        raise IdentificationError(
            f"no mode stands out of the noise between {band[0]:.4g} and {band[1]:.4g} Hz",
            remedy="widen the band, hit harder, or check that the force and the sensors are connected",
        )
    if not fit.refined.settled:
        notes = (
            *notes,
            "The search for the poles had not settled when it was ended; the uncertainties may be too small.",
        )
    notes = (*notes, *_model_error_notes(ratio))
    readings = half_power_readings(fit, groups, rig, band, keep)
    return model_of_fit(fit, keep, rig, "impact", band, readings, notes), fit


def default_band(groups: Groups) -> tuple[float, float]:
    """From the third line to where the blows' spectrum has fallen by 40 dB for good, 0.4 of the rate at most."""
    first = groups[0][0]
    n, rate = first.force.size, first.rate_hz
    power = np.zeros(n // 2 + 1)
    for signals in (s for group in groups for s in group):
        power += np.abs(np.fft.rfft(windowed_force(signals.force, find_blow(signals.force)))) ** 2
    loud = np.flatnonzero(power > power.max() * 10 ** (-FORCE_DROP_DB / 10))
    return LOWEST_LINE * rate / n, min(ANTI_ALIAS_SHARE * rate, float(loud[-1]) * rate / n)


def _start_poles(groups: Groups, rig: Rig, band: tuple[float, float], options: Options) -> NDArray[np.complex128]:
    first = groups[0][0]
    shift = np.log(LEAK) / (first.force.size / first.rate_hz)
    frf = impact_frf(groups, rig, band, damping_shift=float(shift))
    order = options.max_order or min(COLUMNS // len(groups), frf.frequency_hz.size // 2 - 1)
    orders = plscf(frf, order)
    stable = np.array([p.pole for p in stable_poles(orders)], dtype=np.complex128)
    found = start_poles(stable, orders, options)
    if not found.size:
        raise IdentificationError(
            f"no stable pole between {band[0]:.4g} and {band[1]:.4g} Hz up to order {order}",
            remedy="widen the band or look at the FRFs: is there a resonance in them at all?",
        )
    return found


@dataclass(frozen=True, eq=False, slots=True)
class Blows:
    """The blocks at their lines, and what each may have to itself.

    Attributes:
        blocks: in the order of the groups.
        grid: of them all.
        impulse: (blocks,) N s of each blow.
        state_sigma: (blocks,) prior of every modal state, N s; None if the beam looked at rest before every blow.
        force_sigma: (blocks, width) prior of the force samples' errors, N; None if states at the blow stand for them.
    """

    blocks: list[LineBlock]
    grid: Grid
    impulse: NDArray[np.float64]
    state_sigma: NDArray[np.float64] | None
    force_sigma: NDArray[np.float64] | None

    @property
    def at_rest(self) -> bool:
        """Whether the blocks' beginnings have hardly any motion, and their states are therefore known to be small."""
        return self.state_sigma is None


def line_blocks(groups: Groups, rig: Rig, band: tuple[float, float]) -> tuple[Blows, tuple[str, ...]]:
    """The blocks at their lines with what is unknown of each, and notes.

    The force channel's own noise within the blow is estimated sample by sample. If the beam was not at rest before a
    blow, every mode has an unknown state at the block's start. Where the blows are too long for an unknown a sample,
    the states enter at the blow instead and stand for its noise.
    """
    first = groups[0][0]
    n, rate = first.force.size, first.rate_hz
    chosen = lines(n, rate, band)
    grid = Grid(2 * np.pi * chosen * rate / n, n, 1 / rate, DERIVATIVES[output_quantity(rig)])
    flat = [s for group in groups for s in group]
    of_block = [index for index, group in enumerate(groups) for _ in group]
    ringing = [s.block.name for s in flat if _rings_before(s)]
    found = [find_blow(s.force) for s in flat]
    width = min(max(b.stop - b.first for b in found), n - max(b.first for b in found))
    by_sample = width * len(flat) <= MOST_FORCE_SAMPLES
    blocks: list[LineBlock] = []
    for signals, blow, group in zip(flat, found, of_block, strict=True):
        response = np.fft.rfft(signals.responses - quiet_level(signals)[:, None])[:, chosen]
        start = 0 if ringing or by_sample else blow.peak
        force = windowed_force(signals.force, blow)
        blocks.append(LineBlock(BlowExcitation(grid, force, start, blow.first), response, group))
    impulse = np.array([np.sum(np.abs(windowed_force(s.force, b))) for s, b in zip(flat, found, strict=True)]) / rate
    force_sigma = _force_sigma(flat, found, width) if by_sample else None
    state_sigma = impulse if ringing else None if by_sample else _blow_noise(found, impulse, rate)
    return Blows(blocks, grid, impulse, state_sigma, force_sigma), _ringing_notes(ringing)


def _force_sigma(signals: Sequence[Signals], blows: Sequence[Blow], width: int) -> NDArray[np.float64]:
    noise = [max(b.noise, 1e-9 * float(np.max(np.abs(s.force)))) for s, b in zip(signals, blows, strict=True)]
    return np.repeat(np.array(noise)[:, None], width, axis=1)


def _blow_noise(blows: Sequence[Blow], impulse: NDArray[np.float64], rate_hz: float) -> NDArray[np.float64]:
    """(blocks,) sigma in N s of what the force channel's noise adds to each blow."""
    noise = np.array([b.noise * np.sqrt((b.stop - b.first) / 2) for b in blows]) / rate_hz
    return np.maximum(noise, 1e-9 * impulse)


def model_error(fit: Fit, signals: Sequence[Signals]) -> float:
    """How many times the noise of the silence before the blows the fit leaves over, median over outputs.

    1 where the model explains the blocks; NaN where there is too little silence to tell.
    """
    silence = silence_noise(signals)
    return float("nan") if silence is None else float(np.median(fit.point.noise / silence))


def silence_noise(signals: Sequence[Signals]) -> NDArray[np.float64] | None:
    """Noise (outputs,) of a DFT line's real part, from the silence before the blows; None if there is too little."""
    cut = [s.responses[:, : find_blow(s.force).first] for s in signals]
    quiet = [q - q.mean(axis=1, keepdims=True) for q in cut if q.shape[1] > 1]
    free = sum(q.shape[1] - 1 for q in quiet)
    if free * len(signals[0].outputs) < SILENCE_NEEDED:
        return None
    variance = np.sum([np.sum(q**2, axis=1) for q in quiet], axis=0) / free
    # A DFT line's real part holds half of n times the variance of a sample.
    return np.maximum(np.sqrt(variance * signals[0].force.size / 2), np.finfo(float).tiny)


def _model_error_notes(ratio: float) -> tuple[str, ...]:
    if not ratio > MODEL_ERROR_FROM:
        return ()
    return (
        f"The model leaves over {ratio:.3g} times the noise of the silence before the blows: something acts that no "
        "linear modes explain. The uncertainties are too small, and weak modes may stand for what is wrong.",
    )


def _ringing_notes(ringing: Sequence[str]) -> tuple[str, ...]:
    if not ringing:
        return ()
    shown = ", ".join(ringing[:4]) + (" and others" if len(ringing) > 4 else "")
    return (
        f"The beam was still moving before the blow in {shown}; the motion at each block's start was estimated too.",
    )


def _rings_before(signals: Signals) -> bool:
    """Whether the outputs move before the blow by more than the quietest stretch of that output in any block would."""
    stop = find_blow(signals.force).first
    if stop < 32:
        return False
    before = signals.responses[:, :stop] - signals.responses[:, :stop].mean(axis=1, keepdims=True)
    # White noise has no memory; a mode that rings correlates neighbouring samples.
    power = np.sum(before**2, axis=1)
    memory = np.sum(before[:, 1:] * before[:, :-1], axis=1)
    return bool(np.median(memory / np.maximum(power, np.finfo(float).tiny)) > 0.5)


def _refined(
    unknown: Blows,
    poles: NDArray[np.complex128],
    groups: Groups,
    band: tuple[float, float],
    max_iterations: int = MAX_ITERATIONS,
) -> Fit:
    begin = with_stand_ins(poles, band[1], STAND_INS, (1e-4, 0.1))
    known = unknown.state_sigma
    sigma = None if known is None else np.repeat(known[:, None], begin.omega.size, axis=1)
    points = tuple(g[0].block.drive_point for g in groups)
    force = np.zeros((0, 0)) if unknown.force_sigma is None else np.zeros_like(unknown.force_sigma)
    return _searched(unknown, begin, sigma, force, points, max_iterations)


def _again(unknown: Blows, fit: Fit, keep: NDArray[np.bool_], band: tuple[float, float]) -> Fit:
    """The kept modes once more; of a beam that looked at rest with what its sensors cannot have seen."""
    at = fit.point.parameters
    poles = -at.zeta[keep] * at.omega[keep] + 1j * at.omega[keep]
    # Where the stand-in has gone to is where it begins, unless it has become a mode of the band.
    beyond = at.omega[-1] / (2 * np.pi * band[1])
    stand_ins = STAND_INS if keep[-1] or beyond < 1 else (float(beyond),)
    begin = with_stand_ins(poles, band[1], stand_ins, (1e-4, 0.1))
    if unknown.state_sigma is None:
        kept = leftover_sigma(fit, unknown.grid, unknown.impulse)[:, keep]
        nothing = LEAST * np.repeat(unknown.impulse[:, None], begin.stand_ins, axis=1)
        sigma = np.concatenate([kept, nothing], axis=1)
    else:
        sigma = np.repeat(unknown.state_sigma[:, None], begin.omega.size, axis=1)
    return _searched(unknown, begin, sigma, at.force, fit.input_points, MAX_ITERATIONS)


def _without_errors(
    unknown: Blows,
    fit: Fit,
    keep: NDArray[np.bool_],
    signals: Sequence[Signals],
    band: tuple[float, float],
    options: Options,
) -> tuple[Fit, NDArray[np.bool_], float]:
    """The fit without poles that may stand for what is wrong with the model, what is kept, and the misfit's ratio.

    Where the operator has picked or dropped modes, nothing more is taken away.
    """
    ratio = model_error(fit, signals)
    doubtful = keep & (strength(fit) < least_strength(fit, ratio))
    by_hand = bool(options.pick_hz or options.drop_hz)
    if by_hand or not np.any(doubtful) or np.array_equal(doubtful, keep):
        return fit, keep, ratio
    fit = _again(unknown, fit, keep & ~doubtful, band)
    return fit, chosen(fit, band, options, first=False), model_error(fit, signals)


def _searched(
    unknown: Blows,
    begin: StartPoles,
    state_sigma: NDArray[np.float64] | None,
    force: NDArray[np.float64],
    points: tuple[int | None, ...],
    max_iterations: int,
) -> Fit:
    problem = Problem(
        blocks=unknown.blocks,
        powers=RESIDUAL_POWERS,
        n_inputs=len(points),
        state_sigma=state_sigma,
        drive_sigma=None,
        zeta_prior=begin.zeta_prior,
        force_sigma=unknown.force_sigma,
    )
    n = len(unknown.blocks)
    nothing = np.zeros((n, begin.omega.size), complex)
    start = Parameters(begin.omega, begin.zeta, nothing, np.zeros(n, complex), force)
    return Fit(problem, search(problem, start, max_iterations), points)


def half_power_readings(
    fit: Fit, groups: Groups, rig: Rig, band: tuple[float, float], keep: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What the half-power rule reads for each kept mode, and what it would read without any damping, each (kept,)."""
    measured = convert(impact_frf(groups, rig, band), "mobility")
    wanted = fit.point.parameters.omega[keep] / (2 * np.pi)
    order = np.sort(wanted)
    amplitude = summed_amplitude(measured)
    read = np.array([reading_near(measured.frequency_hz, amplitude, f) for f in order])
    floor = np.array([_floor(fit, measured.frequency_hz, f) for f in order])
    return read, floor


def _floor(fit: Fit, frequency_hz: NDArray[np.float64], wanted_hz: float) -> float:
    """Half-power reading of this mode alone in the first block, had it no damping at all."""
    excitation = fit.problem.blocks[0].excitation
    if not isinstance(excitation, BlowExcitation):
        return float("nan")
    grid = replace(excitation.grid, p=1)
    pole = np.array([2j * np.pi * wanted_hz * (1 + 1e-9j)])
    bare = replace(excitation, grid=grid)
    residue = 1 / (2j * 2 * np.pi * wanted_hz)
    response = residue * bare.forced(pole)[0][0] - residue * bare.forced(pole.conj())[0][0]
    force = bare.static(-1)
    return reading_near(frequency_hz, np.abs(response / force), wanted_hz)
