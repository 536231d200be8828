"""Each free number of a fit in words: what it is, where, and how far it lies from what the rig file says."""

from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Real
from modallab.core.digits import percent_text, relative_change
from modallab.core.rig import Rig
from modallab.gap.model.fit import Problem
from modallab.gap.model.tolerances import Deviation, limit_smoothly
from modallab.twin.structure import ROOT

SPOKEN = {"youngs_modulus": "Young's modulus", "thickness": "thickness", "density": "density"}


@dataclass(frozen=True, slots=True)
class FittedNumber:
    """A free number.

    Attributes:
        name: of its tolerance in the rig file.
        place: the channel, the drive point, the mode; "" where there is one only.
        quantity: what it is, in words.
        value: where it ended, or how far from what the rig file says; "" where that says nothing.
    """

    name: str
    place: str
    quantity: str
    value: str = ""

    @property
    def in_words(self) -> str:
        """Quantity and value: `Young's modulus +0.4 %`."""
        return f"{self.quantity} {self.value}".rstrip()


def fitted_numbers(problem: Problem, u: Real) -> list[FittedNumber]:
    """One for each free number at u, in their order."""
    free, rig = problem.free, problem.data.rig
    t = rig.tolerance
    beam = (("youngs_modulus", t.youngs_modulus), ("thickness", t.thickness), ("density", t.density))
    found = [
        FittedNumber(name, "", SPOKEN[name], relative_change(float(limit_smoothly(u[k])) * sigma))
        for k, (name, sigma) in enumerate(beam)
    ]
    ratios = problem.free.build(u[: free.size]).structure.zeta
    found += [
        FittedNumber(
            "damping_ratio", f"mode {k + 1}", f"damping ratio of mode {k + 1}", f"= {percent_text(ratios[k], 4)}"
        )
        for k in range(free.modes)
    ]
    first = 3 + free.modes
    for k, channel in enumerate(free.gains):
        name, off = rig.channels[channel].name, float(limit_smoothly(u[first + k])) * free.tolerance
        found.append(FittedNumber("sensitivity", name, f"sensitivity of {name}", relative_change(off)))
    own = u[free.first_deviation :]
    found += [_deviation_of_number(d, float(v), rig) for d, v in zip(free.deviations, own, strict=False)]
    if free.root:
        softer = np.expm1(float(limit_smoothly(u[free.size - 2])) * ROOT)
        found.append(FittedNumber("clamp", "", "compliance of the clamp", relative_change(softer)))
    return [*found, FittedNumber("residual_terms", "", "modes above those of the simulation")]


def _deviation_of_number(d: Deviation, u: float, rig: Rig) -> FittedNumber:
    value, text = d.value(u), relative_change(d.value(u))
    if d.tolerance in ("position_m", "sensor_mass_kg", "sensitivity"):
        name = rig.channels[int(d.at)].name
        quantity, text = {
            "position_m": (f"position of {name}", f"{1e3 * value:+.2f} mm"),
            "sensor_mass_kg": (f"mass of {name} and its cable", f"{1e3 * value:+.2f} g"),
            "sensitivity": (f"sensitivity of {name}", text),
        }[d.tolerance]
        return FittedNumber(d.tolerance, name, quantity, text)
    if d.tolerance in ("hit_position_m", "hit_gain"):
        place = f"hits at {d.at:.3f} m"
        if d.tolerance == "hit_position_m":
            return FittedNumber(d.tolerance, place, f"mean position of the {place}", f"{1e3 * value:+.2f} mm")
        return FittedNumber(d.tolerance, place, f"force of the {place}", text)
    if d.tolerance in ("stiffness_field", "mass_field"):
        quantity = "bending stiffness" if d.tolerance == "stiffness_field" else "mass per length"
        wave = f"cos {int(d.at) + 1} pi x / L"
        return FittedNumber(d.tolerance, wave, f"{quantity}, as {wave} along the beam,", text)
    if d.tolerance == "damper_n_s_per_m":
        return FittedNumber(d.tolerance, f"{d.at:.3f} m", f"damping to ground at {d.at:.3f} m", f"{value:+.2g} N s/m")
    quantity, text = {
        "clamp_compliance": ("rotational compliance of the clamp", f"= {value:.2g} L/EI"),
        "shaker_mass_kg": ("mass at the shaker", f"{1e3 * value:+.2f} g"),
        "stinger_rotation": ("rotational stiffness of the stinger", f"{value:+.2g} EI/L"),
        "stiffness_drift": ("drift of bending stiffness", text),
    }[d.tolerance]
    return FittedNumber(d.tolerance, "", quantity, text)
