"""Learned elements on the bench: what a diagnosis says that a gap behaves like.

They are played where a rig's revisions hold them. No blind trial draws them: they are no effects.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from math import inf, pi
from types import MappingProxyType

import numpy as np

from modallab.core.arrays import Real, gauss_legendre
from modallab.core.effect import AllChannels, OneChannel
from modallab.core.effects import Effect, EffectKind, Parameter, row_of, x_of
from modallab.core.rig import Rig
from modallab_simulators.cantilever.attached import Absorber, Attachment
from modallab_simulators.cantilever.beam import CantileverBeam, TrueBeam
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart, SideFamily
from modallab_simulators.cantilever.modes import Damper, Modes, SingleMode, TorsionBar
from modallab_simulators.cantilever.sensor import SensorTransfer, high_pass, loose_mount, low_pass

PLACES = 12
"""Springs that stand for an even bedding: Gauss points, exact for the product of two low modes."""


def _beam_law_change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    """A force all along the beam that follows its shape or its deflection."""
    assert rig.beam is not None
    s, law, length = altered.structure, effect.parameters, rig.beam.length_m
    s = replace(s, preload_n=s.preload_n + law.get("tension", 0.0))
    if "bedding" in law:
        at, weights = gauss_legendre(PLACES)
        places, shares = ((at + 1) / 2 * length).tolist(), (weights / 2 * length).tolist()
        springs = [Attachment(x, stiffness=law["bedding"] * w) for x, w in zip(places, shares, strict=True)]
        s = replace(s, attachments=(*s.attachments, *springs))
    return replace(altered, structure=s)


_BEAM_LAW = EffectPart(
    name="beam_law",
    rank=610,
    change=_beam_law_change,
    several=True,
    outside=EffectKind(
        "beam_law",
        "structure",
        (Parameter("tension", "N", 1e-3, 1e6, signed=True),),
        "all",
        "a force all along the beam that follows its shape",
    ),
)


def _point_law_change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    """A force at one place that follows the beam's own motion there."""
    s, law, x = altered.structure, effect.parameters, x_of(effect, rig)
    if "k" in law or "m" in law:
        own = Attachment(x, mass=law.get("m", 0.0), stiffness=law.get("k", 0.0))
        s = replace(s, attachments=(*s.attachments, own))
    if "c" in law:
        s = replace(s, dampers=(*s.dampers, Damper(x, law["c"])))
    if "hung_m" in law:
        hung = Absorber(x, law["hung_m"], law["hung_m"] * (2 * pi * law["hung_hz"]) ** 2)
        s = replace(s, absorbers=(*s.absorbers, hung))
    return replace(altered, structure=s)


_POINT_LAW = EffectPart(
    name="point_law",
    rank=600,
    change=_point_law_change,
    several=True,
    outside=EffectKind(
        "point_law",
        "structure",
        (Parameter("k", "N/m", 1e-3, 1e4, "EI/L^3", signed=True),),
        "x",
        "a force at x that follows the motion there",
    ),
)


def _distorted(law: Mapping[str, float], volts: Real) -> Real:
    if "tanh_v" in law:
        return law["tanh_v"] * np.tanh(volts / law["tanh_v"])
    if "knee_v" in law:
        power = law.get("power", 2.0)
        return volts / (1 + np.abs(volts / law["knee_v"]) ** power) ** (1 / power)
    return volts + law.get("square", 0.0) * volts**2 + law.get("cubic", 0.0) * volts**3


def _row_curve_change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    """A static curve between what one channel would read and what it reads."""
    c = altered.chain
    return replace(
        altered, chain=replace(c, curves={**c.curves, row_of(effect): partial(_distorted, dict(effect.parameters))})
    )


def _row_curve_check(effect: Effect, rig: Rig) -> list[str]:
    if any(name.endswith("_share") for name in effect.parameters):
        return ["row_curve: a level relative to each record's own peak cannot be simulated sample by sample"]
    return []


_ROW_CURVE = EffectPart(
    name="row_curve",
    rank=630,
    change=_row_curve_change,
    several=False,
    check=_row_curve_check,
    outside=EffectKind(
        "row_curve", "sensor", (Parameter("tanh_v", "V", 0.05, 1e4),), "channel", "one channel reads a curve"
    ),
)


def _row_filter_change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    """A linear operator between what one accelerometer feels, or all of them feel, and what is recorded."""
    c, law = altered.chain, effect.parameters
    own = effect.place.channel if isinstance(effect.place, OneChannel) else None
    rows = [c.index for c in rig.responses] if own is None else [own]
    if "gain" in law:
        c = replace(c, gain={**c.gain, **{r: c.gain.get(r, 1.0) * law["gain"] for r in rows}})
    if "delay" in law and own is None:
        c = replace(c, delay_s=c.delay_s + law["delay"])
    made: list[SensorTransfer] = []
    if "delay" in law and own is not None:
        made.append(_late(law["delay"]))
    if "low_pass_hz" in law:
        made.append(low_pass(law["low_pass_hz"]))
    if "high_pass_hz" in law:
        made.append(high_pass(law["high_pass_hz"]))
    if "mount_hz" in law:
        made.append(loose_mount(law["mount_hz"], min(law.get("mount_zeta", 0.04), 0.99)))
    return replace(altered, chain=replace(c, filters=(*c.filters, *((own, sensor) for sensor in made))))


def _late(seconds: float) -> SensorTransfer:
    """An all-pass as late as that where it is late by less than a radian: (1 - s T / 2) / (1 + s T / 2), after Pade."""
    return SensorTransfer(-1.0, (complex(-2 / seconds),), (complex(4 / seconds),))


def _row_filter_check(effect: Effect, rig: Rig) -> list[str]:
    if effect.parameters.get("delay", 0.0) < 0 and not isinstance(effect.place, AllChannels):
        return [f"row_filter: one row of this bench cannot be early, by {-effect.parameters['delay']:g} s"]
    return []


_ROW_FILTER = EffectPart(
    name="row_filter",
    rank=620,
    change=_row_filter_change,
    several=False,
    check=_row_filter_check,
    outside=EffectKind(
        "row_filter",
        "sensor",
        (Parameter("gain", "", 1e-4, 10.0, signed=True, none=1.0),),
        "channel",
        "a linear operator between motion and recording",
    ),
)


def _row_hold_change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    """A channel that loses some of its samples."""
    c, row = altered.chain, row_of(effect)
    kept = c.holds | {row} if effect.parameters.get("kept") else c.holds
    return replace(altered, chain=replace(c, lost_share={**c.lost_share, row: effect.parameters["share"]}, holds=kept))


_ROW_HOLD = EffectPart(
    name="row_hold",
    rank=640,
    change=_row_hold_change,
    several=False,
    outside=EffectKind(
        "row_hold", "acquisition", (Parameter("share", "", 1e-5, 0.5),), "channel", "one channel loses samples"
    ),
)


LOWEST = 3.5160152685
"""(beta L)^2 of a cantilever's first mode."""


def _twist(law: Mapping[str, float], true: TrueBeam, width_m: float) -> Modes:
    """A bar whose angle counts as the displacement: its inertia in kg, so that each mode shows the tip law["kg"]."""
    length = true.beam.length_m
    inertia = 2 * law["kg"] / length
    return TorsionBar(length, inertia * (4 * length * law["twist_hz"]) ** 2, inertia)


def _across(law: Mapping[str, float], true: TrueBeam, width_m: float) -> Modes:
    length = true.beam.length_m
    mass = 4 * law["kg"] / length
    return CantileverBeam(length, mass * (2 * pi * law["across_hz"] * length**2 / LOWEST) ** 2, mass, inf)


def _alone(law: Mapping[str, float], true: TrueBeam, width_m: float) -> Modes:
    return SingleMode(true.beam.length_m, law["alone_hz"], law["kg"], law.get("alone_power", 1.0))


FAMILIES = {"twist_hz": _twist, "across_hz": _across, "alone_hz": _alone}


def _side_modes_change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
    """Modes beside those of bending in the drive's direction."""
    s, law = altered.structure, effect.parameters
    more = (SideFamily(partial(modes, law), 1.0, law["zeta"]) for name, modes in FAMILIES.items() if name in law)
    return replace(altered, structure=replace(s, side_modes=(*s.side_modes, *more)))


_SIDE_MODES = EffectPart(
    name="side_modes",
    rank=615,
    change=_side_modes_change,
    several=True,
    outside=EffectKind(
        "side_modes",
        "structure",
        (Parameter("kg", "kg", 1e-2, 1e6, "m"),),
        "all",
        "modes beside those of bending",
    ),
)


LEARNED_PARTS: Mapping[str, EffectPart] = MappingProxyType(
    {part.name: part for part in (_BEAM_LAW, _POINT_LAW, _ROW_CURVE, _ROW_FILTER, _ROW_HOLD, _SIDE_MODES)}
)
"""Every learned element's part, by its name."""
