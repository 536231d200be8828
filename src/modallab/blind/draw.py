"""Trials on the simulated bench, each with one effect, two or none, and their rigs, as their seeds draw them.

Sizes are log-uniform in the gap they open: that which is left once the beam is fitted within the rig file's tolerances,
as a diagnosis states it, where 1 is the floor. What those tolerances take over opens none.
"""

import hashlib
from dataclasses import dataclass
from datetime import date
from math import exp, log, sqrt

import numpy as np

from modallab.blind.request import BlindRequest
from modallab.blind.trial_bench import TrialBench, trial_bench
from modallab.core.block import Campaign
from modallab.core.effects import Effect, catalogue
from modallab.core.rig import Beam, Channel, Converter, Limits, Point, Rig, Tolerance
from modallab.core.units import STANDARD_GRAVITY
from modallab.gap.report.initial_gap import gap_without_effects
from modallab.twin.effects import effect_models

NONE = "none"
PAIR = "pair"
PAIR_GAP = (100.0, 3000.0)
"""Of two effects at once each is drawn so that alone it would open a gap between these."""
ROUGH_GAP = (30.0, 3000.0)
"""Gaps on a bench where a little of everything is wrong."""
TRIES = 3
EXCEEDING = 6.0
"""Deviations of its own tolerance from which an effect on a bench as built is drawn."""
MATTERS = 1.5
"""Times `tolerance.response` that an effect there moves the response at least: what moves less is rightly no gap."""
ROUGH_TRIES = 8
"""Sizes that are tried for it."""
CLOSE = 0.2
"""Logarithm of the factor by which the gap of a trial may differ from the one that was drawn."""
FURTHER = 2.5
"""The same by which a size changes at most from one try to the next."""

Truth = dict[str, object]
_LENGTH_M = (0.8, 1.2)
_WIDTH_M = (0.04, 0.06)
_FIRST_HZ = (4.2, 6.2)
"""Of the nominal beam, rigidly clamped: its thickness follows."""
_TURNED = 1 / 3
"""Share of accelerometers that are mounted against the drive, and of those that are given in g."""
_POINTS = range(1, 11)
_CALIBRATED = date(2025, 1, 15)


@dataclass(frozen=True, slots=True)
class TrialDraw:
    """One trial to be made.

    Attributes:
        name: of the trial.
        effect: by its name; "none" for a sound bench, "pair" for two of the catalogue.
        seed: of everything in the trial.
        tolerances: how well the bench is put together, "none" (ideally) or "usual".
    """

    name: str
    effect: str
    seed: int
    tolerances: str = "none"


@dataclass(frozen=True, eq=False, slots=True)
class GeneratedTrial:
    """A trial: what the operator has, a later campaign on the same bench if it was asked for, and what is true."""

    campaign: Campaign
    later: Campaign | None
    truth: Truth


def make_trial(draw: TrialDraw, later: bool = True) -> GeneratedTrial:
    """Measure a trial on the simulated bench, and if asked for once more later.

    Its truth holds the gap that its effect opens, in noise units.
    """
    bench, rig = trial_bench(), draw_rig(draw.seed)
    if draw.tolerances != "none":
        rig = with_changed_mounting(rig.model_copy(update={"tolerance": Tolerance.usual()}), draw.seed)
    effects, more = _draw_effects(bench, rig, draw)
    campaign, truth = bench.make_trial(rig, draw.seed, effects, draw.tolerances)
    again = bench.make_trial(rig, draw.seed, effects, draw.tolerances, session=1)[0] if later else None
    return GeneratedTrial(campaign, again, truth | more)


def _draw_effects(bench: TrialBench, rig: Rig, draw: TrialDraw) -> tuple[tuple[Effect, ...], Truth]:
    if draw.effect == NONE:
        return (), {}
    if draw.effect == PAIR:
        return _two_effects(bench, rig, draw.seed), {}
    drawn, more = (_effect_on_ideal_bench if draw.tolerances == "none" else _effect_on_bench_as_built)(bench, rig, draw)
    return (drawn,), more


def _effect_on_ideal_bench(bench: TrialBench, rig: Rig, draw: TrialDraw) -> tuple[Effect, Truth]:
    """An effect whose gap, nuisances fitted, is near the one that was drawn."""
    requested = aim = bench.draw_gap(draw.seed)
    met: list[tuple[float, float, Effect]] = []
    for _ in range(TRIES):
        drawn = bench.draw_effect(rig, draw.seed, draw.effect, aim)
        gap = gap_without_effects(bench.make_trial(rig, draw.seed, (drawn.effect,))[0])
        short = log(sqrt((requested**2 - 1) / max(gap**2 - 1, 0.01)))
        met.append((abs(short), gap, drawn.effect))
        # Some effects have no size, or none that is large or small enough.
        if abs(short) < CLOSE or abs(log(drawn.gap / aim)) > CLOSE:
            break
        aim *= exp(min(max(short, -FURTHER), FURTHER))
    _, gap, effect = min(met, key=lambda m: m[0])
    return effect, {"gap_requested": requested, "gap": gap}


def _effect_on_bench_as_built(bench: TrialBench, rig: Rig, draw: TrialDraw) -> tuple[Effect, Truth]:
    """An effect far beyond its own tolerance that matters, drawn by the gap it would open on an ideal bench."""
    low, high = np.log(ROUGH_GAP)
    gap = float(np.exp(np.random.default_rng([draw.seed, 79]).uniform(low, high)))
    drawn = bench.draw_effect(rig, draw.seed, draw.effect, gap)
    for _ in range(ROUGH_TRIES):
        if _exceeds_own_tolerance(drawn.effect, rig) and drawn.moves > MATTERS * rig.tolerance.response:
            break
        gap *= FURTHER
        drawn = bench.draw_effect(rig, draw.seed, draw.effect, gap)
    return drawn.effect, {"gap": drawn.gap, "moves": drawn.moves}


def _exceeds_own_tolerance(effect: Effect, rig: Rig) -> bool:
    """Whether it is far beyond its own tolerance: what lies within is no gap, and rightly called none."""
    search = effect_models()[effect.effect].search if effect.effect in effect_models() else None
    return search is None or search.tolerance.deviations(effect, rig) > EXCEEDING


def _two_effects(bench: TrialBench, rig: Rig, seed: int) -> tuple[Effect, Effect]:
    """Two effects of the catalogue, each of a size of its own."""
    rng = np.random.default_rng([seed, 78])
    names = _two_of(rng)
    low, high = PAIR_GAP
    sizes = np.exp(rng.uniform(np.log(low), np.log(high), 2))
    first, second = (
        bench.draw_effect(rig, seed, name, float(size)).effect for name, size in zip(names, sizes, strict=True)
    )
    return first, second


def pair_names(seed: int) -> list[str]:
    """What two effects a pair of this seed has, without measuring them."""
    return _two_of(np.random.default_rng([seed, 78]))


def _two_of(rng: np.random.Generator) -> list[str]:
    return [str(name) for name in rng.choice(sorted(catalogue()), 2, replace=False)]


def draw_trials(request: BlindRequest) -> list[TrialDraw]:
    """Trials in an order that says nothing of what is in them: those of one request are always the same."""
    rng = np.random.default_rng([request.seed, 81])
    names = list(request.effects or catalogue())
    first = int(rng.integers(len(names)))
    inside = [names[(first + k) % len(names)] for k in range(request.trials)]
    inside += [NONE] * request.none + [PAIR] * request.pairs
    return [
        TrialDraw(f"trial_{place:04d}", inside[k], _seed_of(request.seed, k), request.tolerances)
        for place, k in enumerate(rng.permutation(len(inside)).tolist())
    ]


def _seed_of(seed: int, number: int) -> int:
    return int.from_bytes(hashlib.sha256(f"modallab blind {seed} {number}".encode()).digest()[:6])


def draw_rig(seed: int) -> Rig:
    """A link that a seed draws, with a point at each tenth of its length; only its beam is not known exactly."""
    rng = np.random.default_rng([seed, 77])
    length, width = round(float(rng.uniform(*_LENGTH_M)), 3), round(float(rng.uniform(*_WIDTH_M)), 4)
    modulus, density = float(rng.choice([195e9, 205e9, 210e9])), 7850.0
    first = float(rng.uniform(*_FIRST_HZ))
    thickness = 2 * np.pi * first * length**2 / 1.875104**2 * np.sqrt(12 * density / modulus)
    return Rig(
        name=f"link {seed}",
        bench="sim://cantilever",
        beam=Beam(
            length_m=length,
            width_m=width,
            thickness_m=round(float(thickness), 5),
            youngs_modulus_pa=modulus,
            density_kg_m3=density,
        ),
        tolerance=Tolerance(youngs_modulus=0.012, thickness=0.003, density=0.003),
        shaker_point=4,
        points=tuple(Point(id=k, x_m=length * k / 10) for k in _POINTS),
        converter=Converter(),
        limits=Limits(drive_v=5.0, slew_v_per_s=5000.0, force_n=20.0, acceleration_m_s2=95.0, max_burst_s=60.0),
        channels=(_force_channel(), *(_accelerometer(k) for k in _POINTS)),
    )


def _force_channel() -> Channel:
    return Channel(
        index=0,
        name="force",
        quantity="force",
        unit="N",
        sensitivity_v_per_unit={"impact": 0.02, "sine": 0.5},
        range_v=10.0,
        serial="FT-0001",
        calibrated_on=_CALIBRATED,
    )


def _accelerometer(k: int) -> Channel:
    return Channel(
        index=k,
        name=f"a{k:02d}",
        quantity="acceleration",
        unit="m/s^2",
        point=k,
        sensitivity_v_per_unit={"impact": 0.01, "sine": 0.1},
        range_v=10.0,
        serial=f"AC-{k:04d}",
        calibrated_on=_CALIBRATED,
    )


def with_changed_mounting(rig: Rig, seed: int) -> Rig:
    """The rig as labs write it down: some accelerometers are mounted against the drive, some are given in g."""
    rng = np.random.default_rng([seed, 80])
    return rig.model_copy(update={"channels": tuple(_mount_channel(c, rng) for c in rig.channels)})


def _mount_channel(channel: Channel, rng: np.random.Generator) -> Channel:
    turned, in_g = rng.random(2) < _TURNED
    if channel.quantity != "acceleration":
        return channel
    own: dict[str, object] = {"direction": "-z" if turned else "+z"}
    if in_g and isinstance(channel.sensitivity_v_per_unit, dict):
        volts = {test: value * STANDARD_GRAVITY for test, value in channel.sensitivity_v_per_unit.items()}
        own |= {"unit": "g", "sensitivity_v_per_unit": volts}
    return channel.model_copy(update=own)
