"""The truth of a bench, drawn by its seed, with what its parts are off, and reported as text.

What has one sign only is half-normal. Noise differs from row to row, and a little hum is there.
"""

import json
from dataclasses import dataclass, replace
from math import ceil, pi

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import ConfigurationError
from modallab.core.rig import FORCE_SHARE, Rig, Tolerance
from modallab.core.units import Test
from modallab_simulators.cantilever.address import EVERYDAY, BenchSettings, SessionConditions
from modallab_simulators.cantilever.assembled import undamped_modes_in_test, with_side_modes
from modallab_simulators.cantilever.attached import KEPT, AttachedModes, Attachment
from modallab_simulators.cantilever.basis import Basis, ModalBasis, TruncatedBasis
from modallab_simulators.cantilever.beam import (
    CantileverBeam,
    RandomStream,
    TrueBeam,
    draw_beam,
    draw_clock,
    draw_damping,
    random_generator,
)
from modallab_simulators.cantilever.effect_part import SIDE_ZETA, AlteredBench, ChainChanges, StructureChanges
from modallab_simulators.cantilever.injected_effects import InjectedEffects, inject_effects
from modallab_simulators.cantilever.modes import DampedBasis, Damper, Modes

TERMS = 3
"""Cosine terms of the fields of EI and rho A."""
NOISE = (0.7, 1.6)
"""Between which factors the noise of a row lies."""
HUM_V = 3e-4
"""Most hum."""
DAMPED = (0.1, 1.0)
"""Between which shares of the length a damper stands."""
MOST = 3.0
"""Deviations beyond which nothing is drawn."""


def bench_as_built(
    altered: AlteredBench, rig: Rig, tolerance: Tolerance, seed: int, lasts_s: float | None
) -> AlteredBench:
    """What effects have left of a bench, with everything a little off.

    Args:
        altered: the bench with its effects.
        rig: with a beam.
        tolerance: one standard deviation each.
        seed: draws it all.
        lasts_s: bench time over which the stiffness drifts, unless an effect says it; None for the usual.
    """
    drawn = _Drawn(random_generator(seed, RandomStream.TOLERANCES), tolerance)
    return AlteredBench(
        _structure(altered.structure, rig, drawn, lasts_s),
        _chain(altered.chain, rig, drawn),
        replace(altered.excitation, scatter_m=tolerance.hit_position_m, gain_scatter=tolerance.hit_gain),
    )


@dataclass(frozen=True, slots=True)
class _Drawn:
    rng: np.random.Generator
    tolerance: Tolerance

    def some(self, sigma: float, count: int) -> list[float]:
        return (np.clip(self.rng.standard_normal(count), -MOST, MOST) * sigma).tolist()

    def one(self, sigma: float) -> float:
        return abs(self.some(sigma, 1)[0])


def _structure(s: StructureChanges, rig: Rig, drawn: _Drawn, lasts_s: float | None) -> StructureChanges:
    t, beam = drawn.tolerance, rig.beam
    assert beam is not None
    ei_l = beam.bending_stiffness_n_m2 / beam.length_m
    turns = drawn.one(t.clamp_compliance)
    places = [rig.x_of(c.point) for c in rig.responses if c.point is not None]
    cables = [
        Attachment(x, mass=abs(m)) for x, m in zip(places, drawn.some(t.sensor_mass_kg, len(places)), strict=True)
    ]
    waves = tuple((k + 1, a) for k, a in enumerate(drawn.some(t.stiffness_field, TERMS)))
    mass_waves = tuple((k + 1, a) for k, a in enumerate(drawn.some(t.mass_field, TERMS)))
    damper = Damper(float(drawn.rng.uniform(*DAMPED)) * beam.length_m, drawn.one(t.damper_n_s_per_m))
    drift = drawn.some(t.stiffness_drift, 1)[0]
    hung = (drawn.one(t.shaker_mass_kg), drawn.one(t.stinger_rotation) * ei_l)
    at_shaker: tuple[Attachment, ...] = ()
    if rig.shaker_point is not None:
        x = rig.x_of(rig.shaker_point)
        at_shaker = (Attachment(x, mass=hung[0]), Attachment(x, 1, stiffness=hung[1]))
    return replace(
        s,
        root_nm_rad=(*s.root_nm_rad, ei_l / turns) if turns else s.root_nm_rad,
        waves=(*s.waves, *(w for w in waves if w[1])),
        mass_waves=(*s.mass_waves, *(w for w in mass_waves if w[1])),
        attachments=(*s.attachments, *(a for a in cables if a.mass)),
        at_shaker=(*s.at_shaker, *(a for a in at_shaker if a.mass or a.stiffness)),
        dampers=(*s.dampers, damper) if damper.c else s.dampers,
        drift=s.drift + drift,
        drift_s=s.drift_s if s.drift or lasts_s is None else lasts_s,
    )


def _chain(c: ChainChanges, rig: Rig, drawn: _Drawn) -> ChainChanges:
    t, beam = drawn.tolerance, rig.beam
    assert beam is not None
    rows = [r.index for r in rig.responses]
    gains, moves = drawn.some(t.sensitivity, len(rows)), drawn.some(t.position_m, len(rows))
    force = drawn.some(FORCE_SHARE * t.sensitivity, 1)[0]
    factors = drawn.rng.uniform(*NOISE, size=len(rig.channels)).tolist()
    hum = float(drawn.rng.uniform(0, HUM_V))
    moved_m = dict(c.moved_m)
    for row, dx in zip(rows, moves, strict=True):
        point = rig.channels[row].point
        if point is not None and row not in moved_m:
            x = rig.x_of(point)
            # Nothing sits beyond the tip.
            moved_m[row] = min(x + dx, beam.length_m) - x
    return replace(
        c,
        gain={row: c.gain.get(row, 1.0) * (1 + g) for row, g in zip(rows, gains, strict=True)},
        force_gain=c.force_gain * (1 + force),
        moved_m=moved_m,
        noise={row: c.noise.get(row, 1.0) * f for row, f in enumerate(factors)},
        hum=c.hum or (hum, 50.0),
    )


BAND_HZ = 1000.0
MAX_MODES = 120
_OVERSAMPLE = 4
_INTERNAL_HZ = 8000.0
_REACH = 0.4


@dataclass(frozen=True, eq=False, slots=True)
class BenchTruth:
    """What the seed has drawn for this bench, and what was put into it.

    Attributes:
        true: the beam.
        clock: how fast the generator's clock runs relative to the converter's, less one.
        zeta: damping ratios that are not drawn.
        seed: which draws.
        rig: where it stands.
        effects: what was put into it.
        few: how many modes the beam has in all; None for as many as there are.
    """

    true: TrueBeam
    clock: float
    zeta: tuple[float, ...]
    seed: int
    rig: Rig
    effects: InjectedEffects
    few: int | None = None

    def modes(self, test: Test, progress: float = 0.0) -> Modes:
        """The undamped structure in a test, at a share of the campaign's time."""
        inertia = self.true.beam.mass_kg_m * self.true.thickness_m**2 / 12
        return undamped_modes_in_test(self.beam_at(progress), self.effects.altered.structure, test, inertia)

    def basis(self, rate_hz: float, test: Test, progress: float, oversample: int) -> Basis:
        """The modes that are integrated in time at a delivered rate: those to 0.4 of the internal rate."""
        internal_hz = rate_hz * oversample
        reach = 2 * pi * _REACH * internal_hz
        modes = self.modes(test, progress)
        count = min(modes.count_below(reach), self.few or MAX_MODES + 1)
        limit = KEPT // 2 if self.effects.effects or self.effects.altered.structure.attachments else MAX_MODES
        if count > limit:
            raise ConfigurationError(
                f"the beam has {count} modes below {_REACH * internal_hz:g} Hz, more than {limit}",
                remedy="choose a shorter or thicker beam in the rig file, or a lower rate",
            )
        changes = self.effects.altered.structure
        if changes.dampers:
            basis: Basis = DampedBasis(modes, self._damping(modes, self.few or KEPT), changes.dampers, reach)
        else:
            basis = ModalBasis(modes, modes.omega(count), self._damping(modes, count))
        basis = TruncatedBasis(basis, self.few) if self.few else basis
        assert self.rig.beam is not None
        return with_side_modes(basis, self.true, changes, self.rig.beam.width_m, reach)

    def _damping(self, modes: Modes, count: int) -> NDArray[np.float64]:
        """Damping ratios of the modes: the beam's own keep theirs where an absorber's stands among them, (count,)."""
        zeta = draw_damping(self.seed, count, self.zeta)
        hung = sorted(modes.attached_modes()) if isinstance(modes, AttachedModes) else []
        for place in hung:
            zeta = np.insert(zeta, place, SIDE_ZETA) if place < count else zeta
        return zeta[:count]

    @property
    def drift(self) -> float:
        """The relative change of EI over the campaign."""
        return self.effects.altered.structure.drift

    def beam_at(self, progress: float) -> CantileverBeam:
        """The bare beam at a share of the campaign's time."""
        beam, change = self.true.beam, 1 + self.drift * progress
        if change == 1:
            return beam
        # The root's spring stays what it is in N m/rad.
        return replace(beam, bending_stiffness_n_m2=beam.bending_stiffness_n_m2 * change, kappa=beam.kappa / change)

    def _modal(self, modes: Modes) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Natural frequencies in rad/s and damping ratios of the modes to 1 kHz, local dampers included."""
        count = modes.count_below(2 * pi * BAND_HZ)
        dampers = self.effects.altered.structure.dampers
        if not dampers:
            return modes.omega(count), self._damping(modes, count)
        poles = DampedBasis(modes, self._damping(modes, KEPT), dampers, np.inf).poles[:count]
        return np.abs(poles), -poles.real / np.abs(poles)

    def facts(self) -> dict[str, str]:
        """What was drawn, as text: numbers in SI units, arrays as JSON, modes to 1 kHz, shapes (modes, points).

        Modes are those before any drift, of the impact test unless they are said to be of the sine test, in which the
        shaker hangs on the beam. Shapes are without local dampers.
        """
        modes, beam = self.modes("impact"), self.true.beam
        count = modes.count_below(2 * pi * BAND_HZ)
        omega, zeta = self._modal(modes)
        hung_omega, hung_zeta = self._modal(self.modes("sine"))
        shapes = modes.shapes(np.array([p.x_m for p in self.rig.points]), count).T
        return {
            "seed": str(self.seed),
            "frequency_hz": json.dumps((omega / (2 * pi)).tolist()),
            "damping_ratio": json.dumps(zeta.tolist()),
            "sine_frequency_hz": json.dumps((hung_omega / (2 * pi)).tolist()),
            "sine_damping_ratio": json.dumps(hung_zeta.tolist()),
            "stiffness_drift": repr(self.drift),
            "points": json.dumps([p.id for p in self.rig.points]),
            "shapes_per_sqrt_kg": json.dumps(shapes.tolist()),
            "youngs_modulus_pa": repr(self.true.youngs_modulus_pa),
            "thickness_m": repr(self.true.thickness_m),
            "density_kg_m3": repr(self.true.density_kg_m3),
            "root_stiffness_nm_per_rad": repr(beam.root_stiffness_nm_rad),
            "generator_ppm": repr(self.clock * 1e6),
            "effects": self.effects.reported(),
        }


def oversampling(rate_hz: float) -> int:
    """Internal samples per delivered one: at least 4, and at least 8 kHz.

    At four, 0.4 of the delivered rate is a tenth of the internal one, where the force between samples is known to
    3e-6; 8 kHz keep the modes to 3.2 kHz in motion whatever the delivered rate.
    """
    return max(_OVERSAMPLE, ceil(_INTERNAL_HZ / rate_hz))


def draw_truth(settings: BenchSettings, rig: Rig, circumstances: SessionConditions = EVERYDAY) -> BenchTruth:
    """Draw the truth of a rig's bench.

    Raises:
        ConfigurationError: the rig describes no cantilever, or none that bends below 1 kHz; or it has no place for an
            effect.
    """
    if rig.model != "cantilever" or rig.beam is None:
        raise ConfigurationError(
            f"the rig {rig.name!r} describes no cantilever", remedy="give it model: cantilever and a beam"
        )
    true = draw_beam(settings.seed, rig.beam, rig.tolerance, settings.k_root)
    if true.beam.count_below(2 * pi * BAND_HZ) == 0:
        first = float(true.beam.omega(1)[0]) / (2 * pi)
        raise ConfigurationError(
            f"the beam's first mode is at {first:.0f} Hz, above {BAND_HZ:g} Hz",
            remedy="choose a longer or thinner beam",
        )
    clock = 0.0 if circumstances.one_clock else draw_clock(settings.seed)
    # What an address names is all there is; else the simulation carries what the rig file's revisions know.
    effects = inject_effects(rig.known_effects if settings.effects is None else settings.effects, rig)
    if settings.tolerances != "none":
        stated = Tolerance.usual() if settings.tolerances == "usual" else rig.tolerance
        built = bench_as_built(effects.altered, rig, stated, settings.seed, circumstances.drift_s)
        effects = replace(effects, altered=built)
    return BenchTruth(true, clock, settings.zeta, settings.seed, rig, effects, circumstances.modes)
