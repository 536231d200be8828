"""The truth of a bench, drawn by its seed, and told as text."""

import json
from dataclasses import dataclass
from math import ceil, pi

import numpy as np

from modallab.errors import ConfigurationError
from modallab.schema.rig import Rig
from modallab_simulators.cantilever.address import Settings
from modallab_simulators.cantilever.draw import TrueBeam, draw_beam, draw_clock, draw_damping
from modallab_simulators.cantilever.structure import ModalBasis

BAND_HZ = 1000.0
MAX_MODES = 200
_OVERSAMPLE = 4
_INTERNAL_HZ = 8000.0
_REACH = 0.4


@dataclass(frozen=True, eq=False, slots=True)
class Truth:
    """What the seed has drawn for this bench."""

    true: TrueBeam
    clock: float
    zeta: tuple[float, ...]
    seed: int

    def basis(self, rate_hz: float) -> ModalBasis:
        """The modes that are integrated in time at a delivered rate: those to 0.4 of the internal rate."""
        internal_hz = rate_hz * oversampling(rate_hz)
        beam = self.true.beam
        count = beam.count_below(2 * pi * _REACH * internal_hz)
        if count > MAX_MODES:
            raise ConfigurationError(
                f"the beam has {count} modes below {_REACH * internal_hz:g} Hz, more than {MAX_MODES}",
                remedy="choose a shorter or thicker beam in the rig file, or a lower rate",
            )
        return ModalBasis(beam, beam.omega(count), draw_damping(self.seed, count, self.zeta))

    def facts(self, rig: Rig) -> dict[str, str]:
        """What was drawn, as text: numbers in SI units, arrays as JSON, modes to 1 kHz, shapes (modes, points)."""
        beam = self.true.beam
        count = beam.count_below(2 * pi * BAND_HZ)
        shapes = beam.shapes(np.array([p.x_m for p in rig.points]), count).T
        return {
            "seed": str(self.seed),
            "frequency_hz": json.dumps((beam.omega(count) / (2 * pi)).tolist()),
            "damping_ratio": json.dumps(draw_damping(self.seed, count, self.zeta).tolist()),
            "points": json.dumps([p.id for p in rig.points]),
            "shapes_per_sqrt_kg": json.dumps(shapes.tolist()),
            "youngs_modulus_pa": repr(self.true.youngs_modulus_pa),
            "thickness_m": repr(self.true.thickness_m),
            "density_kg_m3": repr(self.true.density_kg_m3),
            "root_stiffness_nm_per_rad": repr(beam.root_stiffness_nm_rad),
            "generator_ppm": repr(self.clock * 1e6),
        }


def oversampling(rate_hz: float) -> int:
    """Internal samples per delivered one: at least 4, and at least 8 kHz.

    At four, 0.4 of the delivered rate is a tenth of the internal one, where the force between samples is known to
    3e-6; 8 kHz keep the modes to 3.2 kHz in motion whatever the delivered rate.
    """
    return max(_OVERSAMPLE, ceil(_INTERNAL_HZ / rate_hz))


def draw_truth(settings: Settings, rig: Rig) -> Truth:
    """Draw the truth of a rig's bench.

    Raises:
        ConfigurationError: the rig describes no cantilever, or none that bends below 1 kHz.
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
    return Truth(true, draw_clock(settings.seed), settings.zeta, settings.seed)
