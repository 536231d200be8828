"""Rigs for trials: steel links of many sizes, with ten accelerometers and a shaker as on the demonstration's."""

from importlib.resources import files

import numpy as np

from modallab.core.rig import Beam, Channel, Rig, Tolerance
from modallab.core.units import STANDARD_GRAVITY
from modallab.formats.rig.rig_file import parse_rig

LENGTH_M = (0.8, 1.2)
WIDTH_M = (0.04, 0.06)
FIRST_HZ = (4.2, 6.2)
"""Of the nominal beam, rigidly clamped: its thickness follows."""
TURNED = 1 / 3
"""Share of accelerometers that are mounted against the drive, and of those that are given in g."""


def drawn_rig(seed: int) -> Rig:
    """A link that a seed draws, with a point at each tenth of its length."""
    rng = np.random.default_rng([seed, 77])
    length, width = round(float(rng.uniform(*LENGTH_M)), 3), round(float(rng.uniform(*WIDTH_M)), 4)
    modulus, density = float(rng.choice([195e9, 205e9, 210e9])), 7850.0
    first = float(rng.uniform(*FIRST_HZ))
    thickness = 2 * np.pi * first * length**2 / 1.875104**2 * np.sqrt(12 * density / modulus)
    path = files("modallab.cli") / "link_rig.yaml"
    link = parse_rig(path.read_text(encoding="utf-8"), str(path))
    return link.model_copy(
        update={
            "name": f"link {seed}",
            "beam": Beam(
                length_m=length,
                width_m=width,
                thickness_m=round(float(thickness), 5),
                youngs_modulus_pa=modulus,
                density_kg_m3=density,
            ),
            # Sensors are calibrated: only the beam is not known exactly.
            "tolerance": Tolerance(youngs_modulus=0.012, thickness=0.003, density=0.003),
            "points": tuple(p.model_copy(update={"x_m": length * p.id / 10}) for p in link.points),
        }
    )


def mounted(rig: Rig, seed: int) -> Rig:
    """The rig as labs write it down: some accelerometers are mounted against the drive, some are given in g."""
    rng = np.random.default_rng([seed, 80])
    return rig.model_copy(update={"channels": tuple(_mounted(c, rng) for c in rig.channels)})


def _mounted(channel: Channel, rng: np.random.Generator) -> Channel:
    turned, in_g = rng.random(2) < TURNED
    if channel.quantity != "acceleration":
        return channel
    own: dict[str, object] = {"direction": "-z" if turned else "+z"}
    if in_g and isinstance(channel.sensitivity_v_per_unit, dict):
        volts = {test: value * STANDARD_GRAVITY for test, value in channel.sensitivity_v_per_unit.items()}
        own |= {"unit": "g", "sensitivity_v_per_unit": volts}
    return channel.model_copy(update=own)
