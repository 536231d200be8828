"""The changes that are looked for: on the structure at a point, on a channel, or in the time of all channels."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.gap.modal.compared import Compared
from modallab.gap.modal.free import Change
from modallab.gap.modal.state import Hung
from modallab.modification.freedoms import Freedom, freedoms_of
from modallab.modification.mesh import apart

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

MASSES = np.geomspace(0.004, 1.5, 8)
"""Masses to begin with, over the modal mass seen from there."""
SPRINGS = np.geomspace(0.004, 10.0, 9)
"""Springs, over the modal stiffness seen from there."""
DAMPERS = np.geomspace(0.05, 20.0, 8)
"""Dampers, over the modal damping seen from there."""
HANGS = {
    "added_mass": ("mass_kg", MASSES),
    "ground_spring": ("stiffness", SPRINGS),
    "local_damper": ("damping", DAMPERS),
}
"""Which number of what hangs there is its size, and the sizes to begin with."""
EVERY = ("trigger_delay", "channel_skew")
"""Effects in the time of all channels."""
DELAYS = np.array([-0.6, -0.2, -0.07, 0.07, 0.2, 0.6])
"""Delays to begin with, as a phase at the highest mode; rad."""
PHASE = 0.02
"""By how much the phase of the chain is off at a point, rad; and besides by as much as it is."""
GAINS = (-1.0, 0.2, 0.5, 0.8, 0.9, 0.95, 1.05, 1.1, 1.2, 1.5, 2.0)
SHIFTS = (0.1, 0.3, 0.8)
"""Of a sensor, over the distance to the nearest point."""
ROOM = 7.0
"""By how much, as a logarithm, a mass or a spring may go beyond those to begin with."""
COMPLIANCE_SPREAD = 0.7
"""Deviation of the logarithm of the local compliance."""
MOST_SPREAD = 4.0
"""Largest such logarithm."""


@dataclass(frozen=True, eq=False, slots=True)
class Candidate:
    """A kind of change at a place.

    Attributes:
        effect: its name in the catalogue.
        freedoms: it acts on; none where it is a channel's.
        channel: output number; None for the force and the structure.
        make: numbers -> the change.
        starts: numbers to begin with.
        prior: (numbers,) deviation of each about its start's, infinite where nothing is believed.
        centre: (numbers,) about which.
        beside: so many of the numbers, the last ones, are not the change but what is not known of it.
    """

    effect: str
    freedoms: tuple[Freedom, ...]
    channel: int | None
    make: Callable[[Real], Change] = field(repr=False)
    starts: tuple[Real, ...]
    prior: Real
    centre: Real
    beside: int = 0


def candidates(c: Compared) -> list[Candidate]:
    """All of them; without a driving point none whose size needs the modal mass."""
    hung = [one for effect in HANGS for one in _hung(c, effect)] if c.shapes.scaled else []
    return [*hung, *_gains(c), *_places(c), *_delays(c)]


def spacing(c: Compared) -> float:
    """Median distance from a point to the nearest other, m."""
    return apart(c.shapes.at_m)


def _hung(c: Compared, effect: str) -> Iterator[Candidate]:
    points = list(dict.fromkeys(f[0] for f in c.shapes.freedoms))
    there = [tuple(f for f in c.shapes.freedoms if f[0] == p) for p in points]
    # A mass is moved along every axis, a spring pulls along one.
    groups = there if effect == "added_mass" else [(f,) for group in there for f in group]
    local = c.local_compliance
    for group in groups:
        seen = _seen(c, effect, group)
        if seen <= 0:
            continue
        sizes = HANGS[effect][1] / seen
        tangents = c.shapes.tangents(group[0])
        free = np.linalg.norm(tangents, axis=1) > 0
        step = spacing(c)
        yield Candidate(
            effect,
            group,
            None,
            _hanging(c, effect, group, tangents, step, local, np.log(sizes[[0, -1]]) + np.array([-ROOM, ROOM])),
            tuple(np.array([np.log(size), 0.0, 0.0, 0.0, 0.0]) for size in sizes),
            np.array([np.inf, *np.where(free, step, 1e-9), COMPLIANCE_SPREAD if local else 1e-9, _phase(c)]),
            np.zeros(5),
        )


def _seen(c: Compared, effect: str, group: Sequence[Freedom]) -> float:
    return _felt(c, effect, c.shapes.seen[:, [c.shapes.index(f) for f in group]])


def _felt(c: Compared, effect: str, psi: Complex) -> float:
    """Inverse of the least modal mass, stiffness or damping seen where the shapes are `psi` (modes, directions)."""
    omega = 2 * np.pi * c.model.frequency_hz
    own = {
        "added_mass": np.ones(omega.size),
        "ground_spring": omega**2,
        "local_damper": 2 * c.model.damping_ratio * omega,
    }
    return float(np.max(np.sum(np.abs(psi) ** 2, axis=1) / own[effect]))


def _phase(c: Compared) -> float:
    """Deviation of the phase by which the chain turns what hangs on the structure, rad."""
    turned = abs(np.angle(c.shapes.turn))
    return float(np.hypot(min(turned, np.pi - turned), PHASE))


def nearby(c: Compared, found: Candidate, v: Real, count: int) -> list[tuple[Candidate, Real]]:
    """The same kind of change from other points near its place, each of a size that the modes feel alike."""
    first = found.freedoms[0]
    offset = v[1:3] @ c.shapes.tangents(first)
    here = c.shapes.at_m[c.shapes.index(first)] + offset
    others = [o for o in _hung(c, found.effect) if o.freedoms != found.freedoms and o.freedoms[0][1] == first[1]]
    others.sort(key=lambda o: float(np.linalg.norm(c.shapes.at_m[c.shapes.index(o.freedoms[0])] - here)))
    psi = np.concatenate([c.shapes.moved(f, offset[None]) for f in found.freedoms])
    felt = _felt(c, found.effect, psi.T)
    return [
        (o, np.array([v[0] + np.log(felt / _seen(c, o.effect, o.freedoms)), 0.0, 0.0, *v[3:]])) for o in others[:count]
    ]


def _hanging(
    c: Compared, effect: str, group: tuple[Freedom, ...], tangents: Real, step: float, local: float, within: Real
) -> Callable[[Real], Change]:
    outputs, inputs = _numbers(c, group)
    at = [c.shapes.index(f) for f in group]
    seen, driven = c.shapes.seen[:, at].T, c.shapes.driven[:, at].T
    here = np.concatenate([c.shapes.moved(f, np.zeros((1, 3))) for f in group])

    def make(v: Real) -> Change:
        offset = v[1:3] @ tangents
        away = np.concatenate([c.shapes.moved(f, offset[None]) for f in group]) - here
        size = float(np.exp(np.clip(v[0], *within)))
        return Change(
            Hung(
                seen + away,
                driven + away,
                **{HANGS[effect][0]: size},
                outputs=outputs,
                inputs=inputs,
                compliance=local * float(np.exp(np.clip(v[3], -MOST_SPREAD, MOST_SPREAD))),
                near=float(np.exp(-((np.linalg.norm(offset) / (0.5 * step)) ** 2))) if step else 1.0,
                turn=c.shapes.turn * complex(np.exp(1j * v[4])),
            )
        )

    return make


def _numbers(c: Compared, group: Sequence[Freedom]) -> tuple[tuple[int | None, ...], tuple[int | None, ...]]:
    """Of each freedom the output and the input that stand there, None where none does."""
    outputs, inputs = freedoms_of(c.model, c.rig)
    return (
        tuple(outputs.index(f) if f in outputs else None for f in group),
        tuple(inputs.index(f) if f in inputs else None for f in group),
    )


def _gains(c: Compared) -> Iterator[Candidate]:
    starts = tuple(np.array([g]) for g in GAINS)
    open_, one = np.array([np.inf]), np.ones(1)
    for o in range(len(c.out_psi)):
        yield Candidate("gain_error", (), o, lambda v, o=o: Change(gains=((o, float(v[0])),)), starts, open_, one)
    yield Candidate("force_gain", (), None, lambda v: Change(force_gain=float(v[0])), starts, open_, one)


def _places(c: Compared) -> Iterator[Candidate]:
    step = spacing(c)
    angles, modes = np.arange(8) * np.pi / 4, c.model.n_modes
    for o, slopes in enumerate(c.out_slopes):
        free = np.any(slopes != 0, axis=1)
        if not np.any(free):
            continue
        directions = np.unique(np.round(np.stack([np.cos(angles), np.sin(angles)], 1) * free, 6), axis=0)
        starts = tuple(
            np.append(step * share * d, np.zeros(modes)) for share in SHIFTS for d in directions if np.any(d)
        )
        yield Candidate(
            "position_error",
            (),
            o,
            lambda v, o=o: Change(shifts=((o, v[:2], v[2:]),)),
            starts,
            np.append(np.where(free, np.inf, 1e-9), np.ones(modes)),
            np.zeros(2 + modes),
            modes,
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
            lambda v, late=late: Change(delays=tuple((o, float(v[0] * share)) for o, share in enumerate(late))),
            tuple(np.array([start]) for start in first),
            np.array([np.inf]),
            np.zeros(1),
        )
