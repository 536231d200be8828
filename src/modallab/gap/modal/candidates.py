"""The changes that are looked for: on the structure at a point, on a channel, or in the time of all channels."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from modallab.core.arrays import Real
from modallab.gap.modal.candidate import Candidate
from modallab.gap.modal.compared import Compared
from modallab.gap.modal.free import Change
from modallab.gap.modal.hanging import HANGS, attached_candidates, spacing
from modallab.modification.freedoms import freedoms_of

EVERY = ("trigger_delay", "channel_skew")
"""Effects in the time of all channels."""
DELAYS = np.array([-0.6, -0.2, -0.07, 0.07, 0.2, 0.6])
"""Delays to begin with, as a phase at the highest mode; rad."""
GAINS = (0.2, 0.5, 0.8, 0.9, 0.95, 1.05, 1.1, 1.2, 1.5, 2.0)
GAIN_SPREAD = 1.0
"""Deviation of the logarithm of a gain that is wrong."""
SHIFTS = (0.1, 0.3, 0.8)
"""Of a sensor, over the distance to the nearest point."""
FARTHEST = 3.0
"""The farthest over that distance."""
POWERS = np.arange(4)
"""Of s in the logarithm of what the force channel does otherwise: a gain, a delay, and what is neither."""
ODD = 0.5
"""Deviation of that by each power, at the highest mode; and of a channel's share in another, over what that reads."""
NEXT = 8
"""Other places of sensors to begin with."""


def candidates(c: Compared) -> list[Candidate]:
    """All of them; without a driving point none whose size needs the modal mass."""
    hung = [one for effect in HANGS for one in attached_candidates(c, effect)] if c.shapes.scaled else []
    # Of a force that was not measured nothing is late, and none has a gain.
    of_force = [] if c.bench.operating_shapes is not None else [*_force_gain(), *_delays(c)]
    every = [*hung, *_gains(c), *_places(c), *of_force]
    count = Counter(one.effect for one in every)
    return [replace(one, places=count[one.effect]) for one in every]


def _gains(c: Compared) -> Iterator[Candidate]:
    for o in range(len(c.response_factors)):
        yield from _gain("gain_error", o, lambda gain, o=o: Change(gains=((o, gain),)))


def _force_gain() -> Iterator[Candidate]:
    yield from _gain("force_gain", None, lambda gain: Change(force_gain=gain))


def _gain(effect: str, output: int | None, change: Callable[[float], Change]) -> Iterator[Candidate]:
    """Of either sign, by its logarithm: with one sensor its gain and the force's then begin, and end, alike."""
    for sign in (1.0, -1.0):
        starts = tuple(np.log([[g if output is not None else 1 / g] for g in GAINS]))
        yield Candidate(
            effect,
            (),
            output,
            lambda v, _, sign=sign: change(sign * float(np.exp(v[0]))),
            starts,
            np.array([GAIN_SPREAD]),
            np.zeros(1),
            (),
        )


def _places(c: Compared) -> Iterator[Candidate]:
    step = spacing(c)
    angles, modes = np.arange(8) * np.pi / 4, c.model.n_modes
    for o, slopes in enumerate(c.response_slopes):
        free = np.any(slopes != 0, axis=1)
        if not np.any(free):
            continue
        directions = np.unique(np.round(np.stack([np.cos(angles), np.sin(angles)], 1) * free, 6), axis=0)
        about = [step * share * d for share in SHIFTS for d in directions if np.any(d)]
        starts = tuple(np.append(at, np.zeros(modes)) for at in (*about, *_others(c, o)))
        yield Candidate(
            "position_error",
            (),
            o,
            lambda v, _, o=o: Change(shifts=((o, v[:2], v[2:]),)),
            starts,
            np.append(np.where(free, np.inf, 1e-9), np.ones(modes)),
            np.zeros(2 + modes),
            (2 * FARTHEST * step,) * int(np.sum(free)),
        )


def _others(c: Compared, output: int) -> list[Real]:
    """(2,) m along the tangents from an output to others of its axis, the nearest first."""
    freedoms = freedoms_of(c.model, c.rig)[0]
    tangents, here = c.shapes.tangents(freedoms[output]), c.shapes.at_m[c.shapes.index(freedoms[output])]
    away = [c.shapes.at_m[c.shapes.index(f)] - here for f in freedoms if f[1] == freedoms[output][1]]
    along = [tangents @ a for a in sorted(away, key=np.linalg.norm)]
    return [a for a in along if 0 < np.linalg.norm(a) < FARTHEST * spacing(c)][:NEXT]


def force_channel(c: Compared) -> Candidate:
    """The force's channel does something else than measure the force: it filters, holds, or is late by frequency."""
    top = (2 * np.pi * float(c.model.frequency_hz.max())) ** POWERS
    same = np.ones((len(c.response_factors), 1))

    def make(v: Real, _: Compared) -> Change:
        return Change(force_gain=float(np.exp(-v[0])), filters=same * (v / top)[1:])

    count = POWERS.size
    return Candidate("", (), None, make, (np.zeros(count),), np.full(count, ODD), np.zeros(count), ())


def mixed_channel(c: Compared, output: int) -> list[Candidate]:
    """A channel reads any sum of what all channels should, the force's too; and a share of one of them besides its own.

    Each share is over what the channel itself should read.
    """
    as_read = np.abs(c.s**c.power)[:, None, None] * c.sizes
    each = np.append(np.sqrt(np.mean(as_read**2, axis=(0, 2))), 1.0)
    # A force that was not measured is in no channel.
    every = list(range(each.size - (c.bench.operating_shapes is not None)))
    over, alone = each[output] / each, [n for n in every if n != output]

    def reading(sources: list[int], places: int) -> Candidate:
        def make(v: Real, _: Compared) -> Change:
            shares = np.zeros(each.size)
            shares[sources] = v * over[sources]
            return Change(mixed=(output, shares[:-1], float(shares[-1])))

        n = len(sources)
        return Candidate("", (), output, make, (np.zeros(n),), np.full(n, ODD), np.zeros(n), (), places)

    # Any channel might read so.
    outputs = len(c.response_factors)
    return [reading(every, outputs), *(reading([n], outputs * len(alone)) for n in alone)]


def hits_at(i: int) -> Candidate:
    """The force at one of several driven points is another than is read: hits aslant, or a set-up of its own."""
    spread = np.array([GAIN_SPREAD])
    return Candidate(
        "",
        (),
        None,
        lambda v, _: Change(hit_gains=((i, float(np.exp(v[0]))),)),
        (np.zeros(1),),
        spread,
        np.zeros(1),
        (),
    )


def _delays(c: Compared) -> Iterator[Candidate]:
    index = {channel.name: channel.index for channel in c.rig.channels}
    scanned = np.array([index[name.split("@")[0]] for name in c.model.outputs], float) - c.rig.force_channel.index
    for effect, late in (("trigger_delay", np.ones(scanned.size)), ("channel_skew", scanned)):
        if effect == "channel_skew" and np.ptp(scanned) == 0:
            continue
        first = DELAYS / (2 * np.pi * float(c.model.frequency_hz.max()) * np.abs(late).max())
        yield Candidate(
            effect,
            (),
            None,
            lambda v, _, late=late: Change(filters=-v[0] * late[:, None]),
            tuple(np.array([start]) for start in first),
            np.array([np.inf]),
            np.zeros(1),
            (float(np.ptp(first)),),
        )
