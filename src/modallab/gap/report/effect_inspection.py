"""Effects that no force predicts: read off the records themselves.

Variances add: a row's own noise is what it shows less the rounding, step^2 / 12. The base's motion is the response over
the beam's transmission from its base (`modallab.twin.response`), median over the channels.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from modallab.core.arrays import Real
from modallab.core.diagnosis import FoundEffect
from modallab.core.effect import AllChannels, FixedPlace, OneChannel, Place, channels_of_place
from modallab.core.effects import kind_of, row_of
from modallab.core.rig import Rig
from modallab.core.units import DERIVATIVE
from modallab.gap.conditioning.prepare import ORDINARY_HUM, PreparedCampaign
from modallab.gap.model.forward import predict_record
from modallab.signals.conversion import volts_per_si
from modallab.twin.bench import Twin
from modallab.twin.response import base_transmission

SURE = 0.98
"""Probability of an effect that the records show as such."""
LEVEL = 0.03
"""Relative deviation of a row's noise as it is measured."""
ALIKE = 1.5
"""Factor within which what no force predicts is of the size that it was before: it differs from record to record."""
PLAIN = 6.0
"""A channel shows the base's motion on a line where its power gain is within this factor of a rigid beam's."""
RINGS = 3.0
"""Lines about a pole on which no channel shows it."""


@dataclass(frozen=True, slots=True)
class InspectedEffect:
    """How the records show an effect.

    Attributes:
        shown: whether they do.
        read: the effect with its numbers, once a place; asked only where they do.
    """

    shown: Callable[[PreparedCampaign], bool]
    read: Callable[[PreparedCampaign, Twin], list[FoundEffect]]


def effects_on_records(prepared: PreparedCampaign) -> list[str]:
    """Names of the effects seen on the records."""
    return [name for name, inspection in INSPECTIONS.items() if inspection.shown(prepared)]


def inspect_effects(prepared: PreparedCampaign, twin: Twin) -> list[FoundEffect]:
    """The effects seen on the records, with their numbers."""
    return [found for name in effects_on_records(prepared) for found in INSPECTIONS[name].read(prepared, twin)]


def is_in_revisions(found: FoundEffect, rig: Rig) -> bool:
    """Whether the revisions of the rig hold an effect seen on the records, at its place and of about its size."""
    return any(
        known.effect == found.effect
        and channels_of_place(known.place) == channels_of_place(found.place)
        and all(1 / ALIKE < value / found.parameters[name] < ALIKE for name, value in known.parameters.items())
        for known in rig.known_effects
    )


def noise_share_of_response(prepared: PreparedCampaign, found: FoundEffect) -> float:
    """Share of a row's response that noise or hum make up, median over records, on the row where it is most.

    Of what is neither it is infinite: it is no matter of size.
    """
    if found.effect not in ("mains_hum", "noisy_channel"):
        return float("inf")
    levels = [np.std(b.samples * b.scale[:, None], axis=1) for b in prepared.campaign.blocks]
    level = np.maximum(np.median(np.array(levels), axis=0), 1e-300)
    if found.effect == "noisy_channel":
        row = row_of(found.as_effect())
        return float(prepared.measured_v[row] / level[row])
    assert prepared.hum is not None
    return float(np.max(prepared.hum.volts / np.sqrt(2) / level))


def _found_effect(
    effect: str, parameters: dict[str, float], interval: dict[str, tuple[float, float]], place: Place
) -> FoundEffect:
    return FoundEffect(
        effect=effect,
        stage=kind_of(effect).stage,
        probability=SURE,
        parameters=parameters,
        interval=dict(interval),
        place=place,
    )


def _noisy_channels(prepared: PreparedCampaign, twin: Twin) -> list[FoundEffect]:
    return [_noisy_row(prepared, row) for row in prepared.noisy]


def _noisy_row(prepared: PreparedCampaign, row: int) -> FoundEffect:
    others = np.delete(prepared.measured_v, row)
    ratios = others / np.delete(prepared.believed_v, row)
    # The quantile the measurement takes reads all rows a little low: the other rows say by how much, and how far from
    # its stated noise a sound row may be.
    bias, sound = float(np.median(ratios)), float(np.std(np.log(ratios)))
    rig = prepared.campaign.rig
    counted = prepared.blocks[0].samples.dtype.kind in "iu"
    step = abs(float(prepared.blocks[0].scale[row])) / np.sqrt(12) if counted else 0.0
    own = rig.converter.noise_rms_v if rig.converter is not None else float(np.median(others))
    level = prepared.measured_v[row] / min(max(bias, 0.8), 1.0)
    factor = float(np.sqrt(max(level**2 - step**2, own**2)) / own)
    half = float(np.exp(1.96 * np.hypot(LEVEL, sound)))
    return _found_effect(
        "noisy_channel", {"factor": factor}, {"factor": (factor / half, factor * half)}, OneChannel(channel=row)
    )


def _has_hum(prepared: PreparedCampaign) -> bool:
    if prepared.hum is None:
        return False
    ordinary = ORDINARY_HUM * float(np.median(prepared.noise_v)) if prepared.campaign.rig.tolerance.of_assembly else 0.0
    return float(np.median(prepared.hum.volts)) > ordinary


def _hum_effects(prepared: PreparedCampaign, twin: Twin) -> list[FoundEffect]:
    hum = prepared.hum
    assert hum is not None
    volts = float(np.mean(hum.volts))
    spread = 2 * float(np.mean(prepared.noise_v)) / np.sqrt(len(prepared.blocks) * 500)
    interval = {"volts": (volts - spread, volts + spread), "hz": (hum.hz, hum.hz)}
    return [_found_effect("mains_hum", {"volts": volts, "hz": hum.hz}, interval, AllChannels())]


def _clipping_effects(prepared: PreparedCampaign, twin: Twin) -> list[FoundEffect]:
    found: list[FoundEffect] = []
    for clipped in prepared.clipped:
        share = clipped.volts / max(_predicted_peak(prepared, twin, clipped.row), clipped.volts)
        interval = {"fraction_of_peak": (share * 0.95, min(1.0, share * 1.05))}
        place = OneChannel(channel=clipped.row, level_v=clipped.volts)
        found.append(_found_effect("clipping", {"fraction_of_peak": share}, interval, place))
    return found


def _ringing_effect(prepared: PreparedCampaign, twin: Twin) -> list[FoundEffect]:
    assert prepared.ringing is not None
    fraction = prepared.ringing.fraction
    interval = {"fraction": (0.85 * fraction, 1.15 * fraction)}
    return [_found_effect("residual_ringing", {"fraction": fraction}, interval, FixedPlace(where="impact"))]


def _floor_vibration(prepared: PreparedCampaign, twin: Twin) -> list[FoundEffect]:
    rms = _base_motion(prepared, twin)
    return [
        _found_effect(
            "floor_vibration", {"rms_acc": rms}, {"rms_acc": (0.85 * rms, 1.15 * rms)}, FixedPlace(where="base")
        )
    ]


def _predicted_peak(prepared: PreparedCampaign, twin: Twin, row: int) -> float:
    """Largest voltage the twin says the channel would reach."""
    rig = prepared.campaign.rig
    at = [c.index for c in rig.responses].index(row)
    last = float(max(1, *(b.order for b in prepared.campaign.blocks)))
    peaks = [np.max(np.abs(predict_record(twin, rig, b, last)[at])) for b in prepared.blocks]
    per_si = [abs(volts_per_si(rig, b.test)[row]) for b in prepared.blocks]
    return float(max(peak * volts for peak, volts in zip(peaks, per_si, strict=True)))


def _base_motion(prepared: PreparedCampaign, twin: Twin) -> float:
    """Rms of the base's acceleration: each line by the channels that neither ring nor stand still there."""
    floor = prepared.floor
    assert floor is not None
    rig = prepared.campaign.rig
    lines, block_s = np.arange(floor.density.shape[1]), floor.block_s
    x = np.array([rig.x_of(c.point or 0) for c in rig.responses])
    gain = np.abs(base_transmission(twin.structure, x, 2j * np.pi * np.maximum(lines, 0.3) / block_s)) ** 2
    near = np.min(np.abs(lines[:, None] - np.abs(prepared.poles) * block_s / (2 * np.pi)), axis=1, initial=np.inf)
    reported = (gain > 1 / PLAIN) & (gain < PLAIN) & (near > RINGS)
    base = np.ma.median(np.ma.masked_where(~reported, _as_acceleration(floor.density, rig, block_s) / gain), axis=0)
    known = ~np.ma.getmaskarray(base)
    known[0] = False
    if not np.any(known):
        return floor.rms_acc
    whole = np.interp(lines[1:], lines[known], base.data[known])
    return float(np.sqrt(2 / block_s * np.sum(whole)))


def _as_acceleration(density: Real, rig: Rig, length_s: float) -> Real:
    """(channels, lines) densities of velocities and displacements as those of the accelerations."""
    omega = 2 * np.pi * np.arange(density.shape[1]) / length_s
    missing = np.array([2 - DERIVATIVE[c.quantity] for c in rig.responses])
    return density * omega ** (2 * missing[:, None])


INSPECTIONS = {
    "noisy_channel": InspectedEffect(lambda prepared: bool(prepared.noisy), _noisy_channels),
    "mains_hum": InspectedEffect(_has_hum, _hum_effects),
    "clipping": InspectedEffect(lambda prepared: bool(prepared.clipped), _clipping_effects),
    "residual_ringing": InspectedEffect(lambda prepared: prepared.ringing is not None, _ringing_effect),
    "floor_vibration": InspectedEffect(lambda prepared: prepared.floor is not None, _floor_vibration),
}
"""Each effect that no force predicts, in the order a diagnosis names them."""
