"""What shows in the records that a bench answers out of proportion: overtones, and levels of a sine that disagree."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.gap.conditioning.overtones import harmonics_in_record
from modallab.gap.conditioning.prepare import PreparedCampaign
from modallab.gap.conditioning.rows import SineData
from modallab.gap.model.fit import Fit, all_rows
from modallab.gap.model.forward import forward
from modallab.twin.effect_model import Overtones
from modallab.twin.response import SineBlocks

OFTEN = 0.06
"""Share of sine responses with overtones that is no chance."""
ODD_SHARE = 0.04
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
    return "odd" if thrice > ODD_SHARE else None


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


DEVIATIONS = 5.0
"""Deviations by which the levels of a frequency disagree clearly."""
MOST_RELATIVE = 2e-4
"""Relative difference that converters have without being wrong."""
SEVERAL = 2
"""Frequencies that disagree from which it is no chance."""


def levels_differ(base: Fit) -> bool:
    """Whether what one level answers per newton is not what the other answers, at some frequencies.

    What still rings from the start of a sine, and from the sine before, differs by level on a linear bench too. A
    model that is wrong may have that as wrong as it is large.
    """
    sines = base.problem.data.sines
    return sines is not None and bool(np.count_nonzero(_differences(base, sines) > DEVIATIONS) >= SEVERAL)


def _differences(base: Fit, sines: SineData) -> Real:
    """(frequencies,) deviations between the weakest and the strongest level of each, median over channels."""
    said = forward(base.problem.twin(base.u), base.problem.data)[-1]
    rows, shape = all_rows(base.problem.data)[-1], (len(said), *sines.source.lines.shape)
    of_noise = np.linalg.norm(np.reshape(rows.y / rows.sigma, shape), axis=0)
    middle = shape[-1] // 2
    common = (np.sqrt(rows.common).reshape(shape[1:]) / np.maximum(of_noise, 1e-300))[:, middle]
    y, model, sigma = (np.reshape(v, shape)[:, :, middle] for v in (rows.y, said, rows.sigma))
    found: list[float] = []
    for a, b in _pairs(sines.source):
        rings = np.abs(model[:, a] - model[:, b])
        usual = np.abs(model[:, b]) * (np.hypot(common[a], common[b]) + MOST_RELATIVE)
        noise = np.hypot(sigma[:, a], sigma[:, b]) + usual + rings
        apart = np.abs(y[:, a] - y[:, b] - model[:, a] + model[:, b])
        used = np.isfinite(noise)
        found += [float(np.median(apart[used] / noise[used]))] if np.any(used) else []
    return np.array(found)


def _pairs(source: SineBlocks) -> list[tuple[int, int]]:
    """The weakest and the strongest sine of each frequency that was driven more than once."""
    by_frequency: dict[float, list[int]] = {}
    for j, hz in enumerate(source.frequency_hz):
        by_frequency.setdefault(round(float(hz), 4), []).append(j)
    size = np.abs(source.force)
    driven = [sorted(own, key=lambda j: size[j]) for own in by_frequency.values()]
    return [(own[0], own[-1]) for own in driven if len(own) > 1]
