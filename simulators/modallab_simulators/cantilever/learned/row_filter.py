"""A linear operator between what one accelerometer feels, or all of them feel, and what is recorded."""

from dataclasses import replace

from modallab.core.effect import AllChannels, OneChannel
from modallab.core.effects import Effect, EffectKind, Parameter
from modallab.core.rig import Rig
from modallab_simulators.cantilever.effect_part import AlteredBench, EffectPart
from modallab_simulators.cantilever.sensor import SensorTransfer, high_pass, loose_mount, low_pass


def _change(altered: AlteredBench, effect: Effect, rig: Rig) -> AlteredBench:
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


def _check(effect: Effect, rig: Rig) -> list[str]:
    if effect.parameters.get("delay", 0.0) < 0 and not isinstance(effect.place, AllChannels):
        return [f"row_filter: one row of this bench cannot be early, by {-effect.parameters['delay']:g} s"]
    return []


PART = EffectPart(
    name="row_filter",
    rank=620,
    change=_change,
    several=False,
    check=_check,
    outside=EffectKind(
        "row_filter",
        "sensor",
        (Parameter("gain", "", 1e-4, 10.0, signed=True, none=1.0),),
        "channel",
        "a linear operator between motion and recording",
    ),
)
