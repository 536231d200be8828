"""Each free number of a fit in words: what it is, where, and how far it lies from what the rig file says."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Real
from modallab.core.digits import percent_text, relative_change
from modallab.core.rig import Rig
from modallab.gap.model.fit import Problem
from modallab.gap.model.tolerances import Deviation, held
from modallab.twin.structure import ROOT

SPOKEN = {"youngs_modulus": "Young's modulus", "thickness": "thickness", "density": "density"}


@dataclass(frozen=True, slots=True)
class MovedNumber:
    """A free number.

    Attributes:
        name: of its tolerance in the rig file.
        place: the channel, the drive point, the mode; "" where there is one only.
        said: where it ended, in words.
    """

    name: str
    place: str
    said: str


TIMES = {1: "once", 2: "twice"}


def moved_numbers(problem: Problem, u: Real) -> list[MovedNumber]:
    """One for each free number at u, in their order."""
    free, rig = problem.free, problem.data.rig
    t = rig.tolerance
    beam = (("youngs_modulus", t.youngs_modulus), ("thickness", t.thickness), ("density", t.density))
    found = [
        MovedNumber(name, "", f"{SPOKEN[name]} {relative_change(float(held(u[k])) * sigma)}")
        for k, (name, sigma) in enumerate(beam)
    ]
    ratios = problem.free.build(u[: free.size]).structure.zeta
    found += [
        MovedNumber("damping_ratio", f"mode {k + 1}", f"damping ratio of mode {k + 1}: {percent_text(ratios[k], 4)}")
        for k in range(free.modes)
    ]
    first = 3 + free.modes
    for k, channel in enumerate(free.gains):
        name, off = rig.channels[channel].name, float(held(u[first + k])) * free.tolerance
        found.append(
            MovedNumber("sensitivity", name, f"{name} reads {percent_text(abs(off))} {'high' if off > 0 else 'low'}")
        )
    own = u[free.first_deviation :]
    found += [_deviation_of_number(d, float(v), rig) for d, v in zip(free.deviations, own, strict=False)]
    if free.root:
        found.append(
            MovedNumber(
                "clamp", "", f"compliance of the root {relative_change(np.expm1(float(held(u[free.size - 2])) * ROOT))}"
            )
        )
    return [*found, MovedNumber("residual_terms", "", "modes above those of the twin")]


def _deviation_of_number(d: Deviation, u: float, rig: Rig) -> MovedNumber:
    value = d.value(u)
    if d.tolerance in ("position_m", "sensor_mass_kg", "sensitivity"):
        name = rig.channels[int(d.at)].name
        said = {
            "position_m": f"{name} sits {1e3 * value:+.2f} mm from its point",
            "sensor_mass_kg": f"{name} and its cable weigh {1e3 * value:+.2f} g",
            "sensitivity": f"{name} reads {percent_text(abs(value))} {'high' if value > 0 else 'low'}",
        }[d.tolerance]
        return MovedNumber(d.tolerance, name, said)
    if d.tolerance in ("hit_position_m", "hit_gain"):
        place = f"hits at {d.at:.3f} m"
        off = (
            f"land {1e3 * value:+.2f} mm off"
            if d.tolerance == "hit_position_m"
            else f"give the beam {relative_change(value)}"
        )
        return MovedNumber(d.tolerance, place, f"{place} {off} in the mean")
    if d.tolerance in ("stiffness_field", "mass_field"):
        # A share a cos(k pi x / L): a at the clamp, then k changes of sign.
        what, k = "bending stiffness" if d.tolerance == "stiffness_field" else "mass per length", int(d.at) + 1
        along = f"at the clamp, changing sign {TIMES.get(k, f'{k} times')} along the beam"
        return MovedNumber(d.tolerance, f"cos {k} pi x / L", f"{what} {relative_change(value)} {along}")
    if d.tolerance == "damper_n_s_per_m":
        return MovedNumber(d.tolerance, f"{d.at:.3f} m", f"damper of {value:+.2g} N s/m at {d.at:.3f} m")
    said = {
        "clamp_compliance": f"root turns by {value:.2g} L/EI",
        "shaker_mass_kg": f"{1e3 * value:+.2f} g at the shaker",
        "stinger_rotation": f"stinger holds the rotation with {value:+.2g} EI/L",
        "stiffness_drift": f"bending stiffness drifts by {relative_change(value)}",
    }
    return MovedNumber(d.tolerance, "", said[d.tolerance])
