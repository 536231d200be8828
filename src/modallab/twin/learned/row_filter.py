"""A linear operator between what one accelerometer feels, or all of them feel, and what is recorded."""

from dataclasses import replace

from modallab.core.effect import AllChannels
from modallab.core.effects import Effect, EffectKind, Parameter, row_of
from modallab.core.rig import Beam, Rig
from modallab.twin.bench import Mount, Twin
from modallab.twin.candidate import FreeNumber, spread_logarithmically, values_of_both_signs
from modallab.twin.effect_model import EffectModel, EffectSearch


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    chain, law = twin.chain, effect.parameters
    everywhere = isinstance(effect.place, AllChannels)
    for row in [c.index for c in rig.responses] if everywhere else [row_of(effect)]:
        if "gain" in law:
            chain = replace(chain, gain={**chain.gain, row: chain.gain.get(row, 1.0) * law["gain"]})
        if "delay" in law:
            chain = replace(chain, lag_s={**chain.lag_s, row: chain.lag_s.get(row, 0.0) + law["delay"]})
        if "low_pass_hz" in law:
            chain = replace(chain, low_pass_hz=(*chain.low_pass_hz, (row, law["low_pass_hz"])))
        if "high_pass_hz" in law:
            chain = replace(chain, own_corner_hz={**chain.own_corner_hz, row: law["high_pass_hz"]})
        if "mount_hz" in law:
            chain = replace(chain, mounts=(*chain.mounts, Mount(row, law["mount_hz"], law.get("mount_zeta", 0.04))))
    return replace(twin, chain=chain)


def _slots(beam: Beam) -> tuple[FreeNumber, ...]:
    return (
        FreeNumber("gain", "plain", (0.8, 1.2), none=1.0),
        FreeNumber("delay", "plain", values_of_both_signs(1e-4, 1e-3, 2), scale=1e-3),
        FreeNumber("low_pass_hz", "log", spread_logarithmically(15.0, 1500.0, 6), low=1.0, high=1e6),
        FreeNumber("high_pass_hz", "log", spread_logarithmically(0.1, 10.0, 4), low=1e-4, high=100.0),
        FreeNumber("mount_hz", "log", spread_logarithmically(40.0, 4000.0, 8), low=20.0, high=1e5),
        FreeNumber("mount_zeta", "log", (0.04, 0.4), low=1e-3, high=2.0, power=0.0),
    )


MODEL = EffectModel(
    kind=EffectKind(
        "row_filter",
        "sensor",
        (
            Parameter("gain", "", 1e-4, 10.0, signed=True, none=1.0),
            Parameter("delay", "s", 1e-7, 1e-2, signed=True),
            Parameter("low_pass_hz", "Hz", 1.0, 1e6, spoken="corner frequency of the low-pass"),
            Parameter("high_pass_hz", "Hz", 1e-4, 100.0, spoken="corner frequency of the high-pass"),
            Parameter("mount_hz", "Hz", 20.0, 1e5, spoken="resonance of the mount"),
            Parameter("mount_zeta", "", 1e-3, 2.0, spoken="damping ratio of the mount"),
        ),
        "channel",
        "the recording is the motion times gain, delayed, after a first-order low-pass, a first-order high-pass "
        "and a mount with a resonance, of one channel or of all; missing numbers are zero",
    ),
    rank=30,
    spoken="a linear operator between sensor and record",
    change=_change,
    moves_poles=False,
    once=False,
    search=EffectSearch(rank=30, slots=_slots, inexact=0.01),
    experiment="Exchange the sensor, then its cable, then the input it is plugged into, and repeat the hits.",
)
