"""Effects put exactly into measured FRFs.

What hangs at a freedom f of dynamic stiffness z changes receptances H to H - H_of z H_fi / (1 + z H_ff): all that is
needed was measured where a sensor stands at a driven point (Ewins, Modal Testing, 2nd ed. 2000, section 6.3).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.frf import DERIVATIVES, Frf


@dataclass(frozen=True, slots=True)
class AppliedEffect:
    """An effect with its true numbers.

    Attributes:
        effect: its name in the catalogue.
        value: kg, N/m, N s/m, s, or a factor; of a moved sensor nothing.
        output: it is of; of what hangs on the structure the one that stands there; None for all.
        input: the driven point where it hangs; None elsewhere.
        other: the output in whose place a moved sensor stands.
        sense: -1 where sensor and force at that point are measured in opposite senses, else 1.
    """

    effect: str
    value: float = 0.0
    output: int | None = None
    input: int | None = None
    other: int | None = None
    sense: float = 1.0


def with_effect(frf: Frf, put: AppliedEffect | None) -> Frf:
    """FRFs of the same structure and chain with the effect in them; None: as they are."""
    if put is None:
        return frf
    if put.input is not None and put.output is not None:
        return replace(frf, values=_with_attachment(frf, put, put.output, put.input))
    values = frf.values.copy()
    if put.other is not None and put.output is not None:
        values[put.output] = frf.values[put.other]
        return replace(frf, values=values)
    rows = slice(None) if put.output is None else slice(put.output, put.output + 1)
    if put.effect == "trigger_delay":
        values[rows] *= np.exp(-2j * np.pi * frf.frequency_hz * put.value)
    else:
        # A force channel that reads too much makes every FRF smaller.
        values[rows] *= 1 / put.value if put.effect == "force_gain" else put.value
    return replace(frf, values=values)


def _with_attachment(frf: Frf, put: AppliedEffect, output: int, driven: int) -> NDArray[np.complex128]:
    s = 2j * np.pi * frf.frequency_hz
    # Lines at 0 Hz have no receptance, and nothing that is measured.
    rate = np.where(s == 0, 1.0, s) ** DERIVATIVES[frf.quantity]
    receptance = frf.values / rate
    even = np.ones(s.size)
    by = {"added_mass": s**2, "ground_spring": even, "stiffness_loss": -even, "local_damper": s}
    z = put.value * by[put.effect]
    here = put.sense * receptance[output, driven]
    through = put.sense * z / (1 + z * here)
    changed = receptance - receptance[:, driven, None] * through * receptance[None, output]
    return np.asarray(changed * rate, np.complex128)
