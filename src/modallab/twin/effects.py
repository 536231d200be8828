"""Each linear effect of the catalogue as a change of the twin."""

from collections.abc import Callable
from dataclasses import replace

from modallab.core.effects import Effect
from modallab.core.errors import FormatError
from modallab.core.rig import Rig
from modallab.twin.bench import Mount, Twin

CRACK_WIDTH = 0.04
"""Half width of a stiffness loss over L: the loss falls as exp(-((x - x0) / (0.04 L))^2)."""


def apply(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    """The twin with an effect in it; what a force cannot predict (noise, hum, ringing, floor) leaves it unchanged.

    Raises:
        FormatError: the twin has no model of this effect.
    """
    if effect.effect in UNPREDICTED:
        return twin
    if effect.effect not in _CHANGES:
        raise FormatError(
            f"the twin has no model of {effect.effect!r}", remedy=f"use one of {', '.join(sorted(_CHANGES))}"
        )
    return _CHANGES[effect.effect](twin, effect, rig)


UNPREDICTED = frozenset({"noisy_channel", "mains_hum", "floor_vibration", "residual_ringing", "clipping"})
"""Effects that add to a record what no force predicts, or act on the finished record."""


def _x(effect: Effect, rig: Rig) -> float:
    assert rig.beam is not None
    return float(effect.place["x"]) * rig.beam.length_m  # pyright: ignore[reportArgumentType]


def _channel(effect: Effect) -> int:
    return int(effect.place["channel"])  # pyright: ignore[reportArgumentType]


def _clamp_rotation(twin: Twin, e: Effect, rig: Rig) -> Twin:
    s = twin.structure
    # What is soft beside the root that the rig file states: one spring behind the other.
    added = s.bending_stiffness / s.length_m / e.parameters["k_rot"]
    return replace(twin, structure=replace(s, root_rotation=s.root_rotation + added))


def _clamp_translation(twin: Twin, e: Effect, rig: Rig) -> Twin:
    s = twin.structure
    compliance = s.bending_stiffness / s.length_m**3 / e.parameters["k_trans"]
    return replace(twin, structure=replace(s, root_translation=compliance))


def _added_mass(twin: Twin, e: Effect, rig: Rig) -> Twin:
    s = twin.structure
    return replace(twin, structure=replace(s, masses=(*s.masses, (_x(e, rig), e.parameters["mass"]))))


def _sensor_mass(twin: Twin, e: Effect, rig: Rig) -> Twin:
    s = twin.structure
    each = tuple((rig.x_of(c.point), e.parameters["mass_each"]) for c in rig.responses if c.point is not None)
    return replace(twin, structure=replace(s, masses=(*s.masses, *each)))


def _stiffness_loss(twin: Twin, e: Effect, rig: Rig) -> Twin:
    s = twin.structure
    loss = (_x(e, rig), e.parameters["EI_loss"], CRACK_WIDTH * s.length_m)
    return replace(twin, structure=replace(s, losses=(*s.losses, loss)))


def _ground_spring(twin: Twin, e: Effect, rig: Rig) -> Twin:
    s = twin.structure
    return replace(twin, structure=replace(s, springs=(*s.springs, (_x(e, rig), e.parameters["k"]))))


def _local_damper(twin: Twin, e: Effect, rig: Rig) -> Twin:
    s = twin.structure
    return replace(twin, structure=replace(s, dampers=(*s.dampers, (_x(e, rig), e.parameters["c"]))))


def _thermal_drift(twin: Twin, e: Effect, rig: Rig) -> Twin:
    return replace(twin, ei_drift=twin.ei_drift + e.parameters["EI_drift"])


def _gain(twin: Twin, e: Effect, rig: Rig) -> Twin:
    factor = e.parameters["gain"] if e.effect == "gain_error" else e.parameters["sign"]
    gain = dict(twin.chain.gain)
    gain[_channel(e)] = gain.get(_channel(e), 1.0) * factor
    return replace(twin, chain=replace(twin.chain, gain=gain))


def _swap(twin: Twin, e: Effect, rig: Rig) -> Twin:
    first, second = e.place["channel"]  # pyright: ignore[reportGeneralTypeIssues]
    return replace(twin, chain=replace(twin.chain, swap=(int(first), int(second))))


def _position_error(twin: Twin, e: Effect, rig: Rig) -> Twin:
    shift = {**twin.chain.shift, _channel(e): e.parameters["dx"]}
    return replace(twin, chain=replace(twin.chain, shift=shift))


def _ac_coupling(twin: Twin, e: Effect, rig: Rig) -> Twin:
    return replace(twin, chain=replace(twin.chain, corner_hz=e.parameters["corner_hz"]))


def _loose_mount(twin: Twin, e: Effect, rig: Rig) -> Twin:
    mount = Mount(_channel(e), e.parameters["hz"], e.parameters["zeta"])
    return replace(twin, chain=replace(twin.chain, mounts=(*twin.chain.mounts, mount)))


def _force_gain(twin: Twin, e: Effect, rig: Rig) -> Twin:
    return replace(twin, chain=replace(twin.chain, force_gain=e.parameters["gain"]))


def _channel_skew(twin: Twin, e: Effect, rig: Rig) -> Twin:
    return replace(twin, chain=replace(twin.chain, skew_s=e.parameters["seconds_per_channel"]))


def _trigger_delay(twin: Twin, e: Effect, rig: Rig) -> Twin:
    return replace(twin, chain=replace(twin.chain, delay_s=-e.parameters["seconds"]))


def _clock_error(twin: Twin, e: Effect, rig: Rig) -> Twin:
    return replace(twin, clock=e.parameters["relative"])


def _hit_position(twin: Twin, e: Effect, rig: Rig) -> Twin:
    return replace(twin, hit_shift_m=e.parameters["dx"])


def _stinger_moment(twin: Twin, e: Effect, rig: Rig) -> Twin:
    return replace(twin, stinger_k_rot=e.parameters["k_rot"])


def _shaker_mass(twin: Twin, e: Effect, rig: Rig) -> Twin:
    return replace(twin, shaker_mass_kg=e.parameters["mass"])


_CHANGES: dict[str, Callable[[Twin, Effect, Rig], Twin]] = {
    "clamp_rotation": _clamp_rotation,
    "clamp_translation": _clamp_translation,
    "added_mass": _added_mass,
    "sensor_mass": _sensor_mass,
    "stiffness_loss": _stiffness_loss,
    "ground_spring": _ground_spring,
    "local_damper": _local_damper,
    "thermal_drift": _thermal_drift,
    "gain_error": _gain,
    "polarity": _gain,
    "swap": _swap,
    "position_error": _position_error,
    "ac_coupling": _ac_coupling,
    "loose_mount": _loose_mount,
    "force_gain": _force_gain,
    "channel_skew": _channel_skew,
    "trigger_delay": _trigger_delay,
    "clock_error": _clock_error,
    "hit_position": _hit_position,
    "stinger_moment": _stinger_moment,
    "shaker_mass": _shaker_mass,
}
