"""Whether the beam answers a sine with overtones that the force does not hold."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.gap.conditioning.overtones import harmonics_in_record
from modallab.gap.conditioning.prepare import PreparedCampaign
from modallab.twin.effect_model import Overtones

OFTEN = 0.06
"""Share of sine responses with overtones that is no chance."""
SEVERAL = 0.04
"""Share of a channel's sine responses with a harmonic that is more than one or two."""
BROKEN = 0.4
"""Second harmonics for each third one up to which a law may answer alike both ways.

At a few sines such a law breaks its own symmetry (Parlitz and Lauterborn, Phys. Lett. A 107, 1985, 351); one that does
not makes second ones wherever it makes third ones.
"""
ORDERS = (2, 3)
"""Multiples of a sine's frequency that are looked at."""
CLEAR_OF_NOISE = 8.0
"""Times the noise on a line from which a harmonic is clear."""
CLEAR_OF_LINES = 3.0
"""Times what stands beside it that it must be as well."""


def channels_out_of_proportion(prepared: PreparedCampaign) -> Overtones | None:
    """Which overtones show that the beam answers out of proportion, if any do: harmonics that the force does not hold.

    They must be on most channels: a channel that saturates has them alone. What answers alike both ways makes third
    ones without second ones; what does not, as a crack that opens, makes second ones.
    """
    rows = [c.index for c in prepared.campaign.rig.responses]
    clear, usable = _clear_harmonics(prepared)
    second, third = (_rows_with_harmonics(clear[k], usable) for k in ORDERS)
    force = prepared.campaign.rig.force_channel.index
    if max(third[force], second[force]) > OFTEN:
        return None
    twice, thrice = float(np.median(second[rows])), float(np.median(third[rows]))
    if twice > max(OFTEN, BROKEN * thrice):
        return "even"
    return "odd" if thrice > SEVERAL else None


def harmonic_shares(prepared: PreparedCampaign) -> tuple[float, float]:
    """Share of sine responses, and of their forces, with clear second or third harmonics."""
    rig = prepared.campaign.rig
    by_order, usable = _clear_harmonics(prepared)
    clear = by_order[2] | by_order[3]
    rows, force = [c.index for c in rig.responses], rig.force_channel.index
    responses = clear[:, rows][usable[:, rows]]
    return float(np.mean(responses)) if responses.size else 0.0, float(np.mean(clear[:, force])) if len(clear) else 0.0


def _rows_with_harmonics(clear: NDArray[np.bool_], usable: NDArray[np.bool_]) -> Real:
    return np.sum(clear & usable, axis=0) / np.maximum(np.sum(usable, axis=0), 1)


def _clear_harmonics(prepared: PreparedCampaign) -> tuple[dict[int, NDArray[np.bool_]], NDArray[np.bool_]]:
    """(sine blocks, rows) by order whether a harmonic is clear, and whether the row is to be used."""
    sines = [b for b in prepared.blocks if b.test == "sine" and b.frequency_hz]
    shape = len(sines), len(prepared.campaign.rig.channels)
    clear = {order: np.zeros(shape, dtype=bool) for order in ORDERS}
    for which, b in enumerate(sines):
        hz = (b.frequency_hz or 0.0) * prepared.sine_ratio
        for tone in harmonics_in_record(b.name, b.samples * b.scale[:, None], b.rate_hz, hz):
            if tone.order in clear:
                size = np.abs(tone.y)
                above_noise = size * np.sqrt(b.n_samples / 2) > CLEAR_OF_NOISE * prepared.noise_v
                clear[tone.order][which] = above_noise & (size > CLEAR_OF_LINES * tone.beside)
    usable = [[(b.name, row) not in prepared.masked for row in range(shape[1])] for b in sines]
    return clear, np.array(usable, dtype=bool).reshape(shape)
