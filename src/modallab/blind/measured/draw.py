"""Which effects are put into measured FRFs, of which size, and how each is put exactly.

What hangs at a freedom f of dynamic stiffness z changes receptances H to H - H_of z H_fi / (1 + z H_ff): all that is
needed was measured where a sensor stands at a driven point (Ewins, Modal Testing, 2nd ed. 2000, section 6.3).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from modallab.core.arrays import Real
from modallab.core.frf import DERIVATIVES, Frf
from modallab.core.frozen import Frozen, is_not_stated
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.modification.freedoms import freedoms_of


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


ON_STRUCTURE = ("added_mass", "ground_spring", "local_damper", "stiffness_loss")
HANGING = (0.005, 0.2)
"""Masses, springs and lost stiffness, over the least modal mass or stiffness at their point."""
DAMPING = (0.2, 3.0)
"""Dampers, over the modal damping there."""
GAIN = (0.05, 0.5)
"""By how much a sensor reads too much or too little."""
DIFFERENT = 0.1
"""Share of a sensor's modal constants by which it has to read otherwise where it is moved to."""
DELAY = (0.03, 0.6)
"""Delays, as a phase at the highest mode; rad."""


class MeasuredRequest(Frozen):
    """Which trials are made of a campaign.

    Attributes:
        trials: with one effect.
        none: without.
        seed: draws everything.
        band_hz: (low, high) of the lines that are used; None for all.
    """

    trials: Annotated[int, Field(ge=0, le=10_000)] = 20
    none: Annotated[int, Field(ge=0, le=10_000)] = 5
    seed: Annotated[int, Field(ge=0, lt=2**32)] = 0
    band_hz: tuple[float, float] | None = Field(default=None, exclude_if=is_not_stated)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not self.trials + self.none:
            raise ValueError("no trial is requested")
        return self


def draw_effects(model: ModalModel, rig: Rig, request: MeasuredRequest) -> list[AppliedEffect | None]:
    """The effects of all trials, None for nothing done, in an order that says nothing."""
    rng = np.random.default_rng(request.seed)
    kinds = _drawable_kinds(model, rig)
    found: list[AppliedEffect | None] = [kinds[int(rng.integers(len(kinds)))](rng) for _ in range(request.trials)]
    found += [None] * request.none
    return [found[n] for n in rng.permutation(len(found))]


def driving_points(model: ModalModel, rig: Rig) -> list[tuple[int, int]]:
    """(output, input) of each sensor that stands at a driven point, along the drive."""
    outputs, inputs = freedoms_of(model, rig)
    return [(o, i) for o, f in enumerate(outputs) for i, g in enumerate(inputs) if f == g]


def _drawable_kinds(model: ModalModel, rig: Rig) -> list[Callable[[np.random.Generator], AppliedEffect]]:
    outputs = len(model.outputs)
    kinds: list[Callable[[np.random.Generator], AppliedEffect]] = [
        lambda rng: AppliedEffect("gain_error", _draw_gain(rng), output=int(rng.integers(outputs))),
        lambda rng: AppliedEffect(
            "trigger_delay", _draw_sign(rng) * _draw_logarithmic(rng, DELAY) / float(_angular_frequencies(model).max())
        ),
    ]
    if driving_points(model, rig):
        kinds += [partial(_draw_attached_effect, model, rig, effect) for effect in ON_STRUCTURE]
    if any(_places_beside(model, rig, o) for o in range(outputs)):
        kinds.append(partial(_draw_moved_sensor, model, rig))
    return kinds


def _draw_attached_effect(model: ModalModel, rig: Rig, effect: str, rng: np.random.Generator) -> AppliedEffect:
    points = driving_points(model, rig)
    output, driven = points[int(rng.integers(len(points)))]
    omega, zeta = _angular_frequencies(model), model.damping_ratio
    by = {"added_mass": np.ones(omega.size), "local_damper": 2 * zeta * omega}
    own = by.get(effect, omega**2)
    least = float(np.min(own / np.abs(model.modal_constants[:, output, driven])))
    share = _draw_logarithmic(rng, DAMPING if effect == "local_damper" else HANGING)
    sense = -1.0 if np.sum(model.modal_constants[:, output, driven].real) < 0 else 1.0
    return AppliedEffect(effect, share * least, output, driven, sense=sense)


def _draw_moved_sensor(model: ModalModel, rig: Rig, rng: np.random.Generator) -> AppliedEffect:
    there = [(o, others) for o in range(len(model.outputs)) if (others := _places_beside(model, rig, o))]
    output, others = there[int(rng.integers(len(there)))]
    return AppliedEffect("position_error", output=output, other=others[0])


def _places_beside(model: ModalModel, rig: Rig, output: int) -> list[int]:
    """Outputs along the same axis at other places that move otherwise, the nearest first."""
    freedoms, _ = freedoms_of(model, rig)
    at = places_of(model, rig)
    away = np.linalg.norm(at - at[output], axis=1)
    there = [int(o) for o in np.argsort(away) if away[o] > 0 and freedoms[o][1] == freedoms[output][1]]
    return [o for o in there if _modes_differ_at(model, output, o)]


def _modes_differ_at(model: ModalModel, one: int, other: int) -> bool:
    """Whether the modes move otherwise there: where they do not, a moved sensor has not been moved."""
    constants = model.modal_constants[:, [one, other]]
    return float(np.linalg.norm(constants[:, 0] - constants[:, 1])) > DIFFERENT * float(np.linalg.norm(constants[:, 0]))


def places_of(model: ModalModel, rig: Rig) -> Real:
    """(outputs, 3) where they stand, m."""
    points = {p.id: (p.x_m, p.y_m, p.z_m) for p in rig.points}
    return np.array([points[p or 0] for p in model.output_points])


def _draw_gain(rng: np.random.Generator) -> float:
    return -1.0 if rng.random() < 0.2 else 1 + _draw_sign(rng) * _draw_logarithmic(rng, GAIN)


def _draw_sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _draw_logarithmic(rng: np.random.Generator, within: tuple[float, float]) -> float:
    return float(np.exp(rng.uniform(*np.log(within))))


def _angular_frequencies(model: ModalModel) -> Real:
    return 2 * np.pi * model.frequency_hz
