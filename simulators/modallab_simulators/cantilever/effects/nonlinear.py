"""The nonlinear effects of the structure as elements to be fed back, and the root they stand on."""

from collections.abc import Mapping
from math import inf

from modallab_simulators.cantilever.beam import CantileverBeam
from modallab_simulators.cantilever.effects.injected import Injected
from modallab_simulators.cantilever.feedback.elements import CrackElement, Drag, PointElement


def joint_stiffness(effects: Injected) -> float:
    """The stiffest a joint at the root gets, in N m/rad; inf without one."""
    if effects.one("clamp_friction"):
        return effects.number("clamp_friction", "k_stick", inf)
    return effects.number("clearance", "k_contact", inf) + effects.number("clearance", "k_within", 0.0)


def elements_of(beam: CantileverBeam, effects: Injected) -> list[PointElement | CrackElement]:
    """The local elements on a beam whose root already has the joint at its stiffest."""
    length, found = beam.length_m, list[PointElement | CrackElement]()
    found += [_friction(beam, e.parameters) for e in effects.of("clamp_friction")]
    found += [_play(beam, e.parameters) for e in effects.of("clearance")]
    found += [PointElement(_x(e.place) * length, 0, "cubic", (e.parameters["k3"],)) for e in effects.of("cubic_spring")]
    found += [
        CrackElement(_x(e.place) * length, e.parameters["EI_loss_open"], beam.bending_stiffness_n_m2)
        for e in effects.of("breathing_crack")
    ]
    return found


# A spring in series with a joint of two stiffnesses makes it another such joint: each stiffness in series with the
# spring, and the change from one to the other at the same moment.


def _friction(beam: CantileverBeam, numbers: Mapping[str, float]) -> PointElement:
    slip, stick, root = numbers["k_slip"], numbers["k_stick"], beam.root_stiffness_nm_rad
    series = 1 / root - 1 / stick
    slider = root - 1 / (1 / slip + series)
    moment = numbers["moment_limit"] * stick / (stick - slip)
    return PointElement(0.0, 1, "friction", (slider, moment * slider / root))


def _play(beam: CantileverBeam, numbers: Mapping[str, float]) -> PointElement:
    within, gap, root = numbers.get("k_within", 0.0), numbers["gap"], beam.root_stiffness_nm_rad
    series = 1 / root - 1 / (numbers["k_contact"] + within)
    soft = within / (1 + within * series)
    return PointElement(0.0, 1, "play", (root - soft, gap * (1 + within * series)))


def drag_of(effects: Injected, length_m: float) -> Drag | None:
    """The air's drag."""
    total = effects.number("air_drag", "c2_total", 0.0)
    return Drag(total / length_m) if total else None


def _x(place: object) -> float:
    assert isinstance(place, dict)
    return float(place["x"])  # pyright: ignore[reportUnknownArgumentType]
