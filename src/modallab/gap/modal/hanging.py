"""What may hang on the structure: a mass, a spring or a damper at, or about, a point; and what stiffness it lost."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex, Real
from modallab.gap.modal.candidate import Candidate
from modallab.gap.modal.compared import Compared
from modallab.gap.modal.free import Change
from modallab.gap.modal.state import AttachedElement
from modallab.modification.freedoms import Freedom, freedoms_of
from modallab.modification.mesh import median_spacing

MASSES = np.geomspace(0.004, 1.5, 8)
"""Masses to begin with, over the modal mass seen from there."""
SPRINGS = np.geomspace(0.004, 10.0, 9)
"""Springs, over the modal stiffness seen from there."""
DAMPERS = np.geomspace(0.05, 20.0, 8)
"""Dampers, over the modal damping seen from there."""
LOSSES = np.geomspace(0.004, 0.95, 8)
"""Stiffness lost to ground or between points, over the modal stiffness seen from there."""
HANGS = {
    "added_mass": MASSES,
    "ground_spring": SPRINGS,
    "local_damper": DAMPERS,
    "stiffness_loss": LOSSES,
}
"""The sizes to begin with, in the order of the numbers of what hangs there."""
BETWEEN = ("ground_spring", "local_damper", "stiffness_loss")
"""What may act between two points."""
BESIDE = 3
"""Points next to one, as far as that reaches."""
PHASE = 0.02
"""By how much the phase of the chain is off at a point, rad; and besides by as much as it is."""
ROOM = 7.0
"""By how much, as a logarithm, a mass or a spring may go beyond those to begin with."""
COMPLIANCE_SPREAD = 0.7
"""Deviation of the logarithm of the local compliance."""
MOST_SPREAD = 4.0
"""Largest such logarithm."""


def spacing(c: Compared) -> float:
    """Median distance from a point to the nearest other, m."""
    return median_spacing(c.shapes.at_m)


def attached_candidates(c: Compared, effect: str) -> Iterator[Candidate]:
    """One kind at each point where it can be felt, and between points next to each other where it may act there."""
    yield from _on_points(c, effect)
    if effect in BETWEEN:
        yield from (_between(c, effect, pair) for pair in _pairs(c) if _seen(c, effect, pair) > 0)


def _on_points(c: Compared, effect: str) -> Iterator[Candidate]:
    points = list(dict.fromkeys(f[0] for f in c.shapes.freedoms))
    there = [tuple(f for f in c.shapes.freedoms if f[0] == p) for p in points]
    # A mass is moved along every axis, a spring pulls along one.
    groups = there if effect == "added_mass" else [(f,) for group in there for f in group]
    for group in groups:
        if _seen(c, effect, group) <= 0:
            continue
        if len(group) == 1 and None not in sum(_numbers(c, group), ()):
            yield _at_point(c, effect, group)
        yield _about_point(c, effect, group)


def _pairs(c: Compared) -> list[tuple[Freedom, Freedom]]:
    """Freedoms along one axis at points next to each other."""
    found: dict[tuple[Freedom, Freedom], None] = {}
    for f, here in zip(c.shapes.freedoms, c.shapes.at_m, strict=True):
        others = [g for g in c.shapes.freedoms if g[1] == f[1] and g[0] != f[0]]
        others.sort(key=lambda g: float(np.linalg.norm(c.shapes.at_m[c.shapes.index(g)] - here)))
        found |= dict.fromkeys((min(f, g), max(f, g)) for g in others[:BESIDE])
    return list(found)


def _between(c: Compared, effect: str, pair: tuple[Freedom, Freedom]) -> Candidate:
    outputs, inputs = _numbers(c, pair)
    at, (logs, within) = [c.shapes.index(f) for f in pair], _sizes(c, effect, pair)
    seen, driven = _with_damping(c, effect, c.shapes.seen[:, at].T, c.shapes.driven[:, at].T)
    local = c.local_compliance

    def make(v: Real, _: Compared) -> Change:
        size = _numbers_of(effect, float(np.exp(np.clip(v[0], *within))))
        turn = c.shapes.turn * complex(np.exp(1j * v[1]))
        hung = AttachedElement(
            seen, driven, *size, outputs=outputs, inputs=inputs, compliance=local, turn=turn, opposed=True
        )
        return Change(hung)

    starts = tuple(np.array([log, 0.0]) for log in logs)
    return Candidate(
        effect, pair, None, make, starts, np.array([np.inf, _phase(c)]), np.zeros(2), (float(np.ptp(logs)),)
    )


def _at_point(c: Compared, effect: str, group: tuple[Freedom, ...]) -> Candidate:
    """At a driven point where a sensor stands: all that is needed was measured there."""
    (out,), (into,) = _numbers(c, group)
    at = [c.shapes.index(f) for f in group]
    seen, driven = _with_damping(c, effect, c.shapes.seen[:, at].T, c.shapes.driven[:, at].T)
    logs, within = _sizes(c, effect, group)

    def make(v: Real, there: Compared) -> Change:
        size = _numbers_of(effect, float(np.exp(np.clip(v[0], *within))))
        turn = c.shapes.turn * complex(np.exp(1j * v[1]))
        hung = AttachedElement(seen, driven, *size, outputs=(out,), inputs=(into,), turn=turn)
        return Change(there.by_lines(hung))

    # The common phase may be the chain's, or that of the structure with a hit beside its point.
    own = -float(np.angle(c.shapes.turn * np.sign(c.shapes.turn.real)))
    starts = tuple(np.array([log, phase]) for log in logs for phase in (0.0, own))
    prior = np.array([np.inf, _phase(c)])
    return Candidate(effect, group, None, make, starts, prior, np.zeros(2), (float(np.ptp(logs)),))


def _about_point(c: Compared, effect: str, group: tuple[Freedom, ...]) -> Candidate:
    logs, within = _sizes(c, effect, group)
    tangents, local, step = c.shapes.tangents(group[0]), c.local_compliance, spacing(c)
    free, shapes = np.linalg.norm(tangents, axis=1) > 0, len(group) * c.model.n_modes
    believed = [np.inf, *np.where(free, step, 1e-9), COMPLIANCE_SPREAD if local else 1e-9, _phase(c)]
    return Candidate(
        effect,
        group,
        None,
        _hanging(c, effect, group, tangents, step, local, within),
        tuple(np.append(log, np.zeros(4 + shapes)) for log in logs),
        np.append(believed, np.ones(shapes)),
        np.zeros(5 + shapes),
        (float(np.ptp(logs)),),
    )


def _numbers_of(effect: str, size: float) -> tuple[float, float, float]:
    """Mass, stiffness and damping."""
    of = {"added_mass": (size, 0.0, 0.0), "ground_spring": (0.0, size, 0.0), "local_damper": (0.0, 0.0, size)}
    return of.get(effect, (0.0, -size, 0.0))


def _with_damping(c: Compared, effect: str, seen: Complex, driven: Complex) -> tuple[Complex, Complex]:
    """Shapes (directions, modes) where a change is, and those of the damping that goes with it.

    Stiffness that is lost takes its damping along: where all of it is lost alike, modes keep their damping ratios.
    """
    if effect != "stiffness_loss":
        return seen, driven
    share = np.sqrt(c.model.damping_ratio / (np.pi * c.model.frequency_hz)) * _elastic(c)
    return np.concatenate([seen, seen * share]), np.concatenate([driven, driven * share])


def _sizes(c: Compared, effect: str, group: Sequence[Freedom]) -> tuple[Real, Real]:
    """Logarithms of sizes to begin with, and (2,) between which they stay."""
    logs = np.log(HANGS[effect] / _seen(c, effect, group))
    return logs, logs[[0, -1]] + np.array([-ROOM, ROOM])


def _seen(c: Compared, effect: str, group: Sequence[Freedom]) -> float:
    psi = c.shapes.seen[:, [c.shapes.index(f) for f in group]]
    return _felt(c, effect, psi[:, :1] - psi[:, 1:] if two_points(group) else psi)


def _felt(c: Compared, effect: str, psi: Complex) -> float:
    """Inverse of the least modal mass, stiffness or damping seen where the shapes are `psi` (modes, directions)."""
    omega = 2 * np.pi * c.model.frequency_hz
    own = {
        "added_mass": np.ones(omega.size),
        "ground_spring": omega**2,
        "stiffness_loss": omega**2,
        "local_damper": 2 * c.model.damping_ratio * omega,
    }
    return float(np.max((np.sum(np.abs(psi) ** 2, axis=1) / own[effect])[_elastic(c)]))


def _elastic(c: Compared) -> NDArray[np.bool_]:
    """(modes,) which are none of a body that moves as a whole: that has no stiffness and no damping of its own."""
    return np.asarray(c.model.frequency_hz >= c.model.band_hz[0])


def two_points(group: Sequence[Freedom]) -> bool:
    """Whether something acts between two points."""
    return len({point for point, _ in group}) > 1


def _phase(c: Compared) -> float:
    """Deviation of the phase by which the chain turns what hangs on the structure, rad."""
    turned = abs(np.angle(c.shapes.turn))
    return float(np.hypot(min(turned, np.pi - turned), PHASE))


def candidates_nearby(c: Compared, found: Candidate, v: Real, count: int) -> list[tuple[Candidate, Real]]:
    """The same kind of change from other points near its place, each of a size that the modes feel alike."""
    first = found.freedoms[0]
    if two_points(found.freedoms):
        return []
    offset = found.offset(v) @ c.shapes.tangents(first)
    here = c.shapes.at_m[c.shapes.index(first)] + offset
    others = [o for o in _on_points(c, found.effect) if o.freedoms != found.freedoms and o.freedoms[0][1] == first[1]]
    others.sort(key=lambda o: float(np.linalg.norm(c.shapes.at_m[c.shapes.index(o.freedoms[0])] - here)))
    psi = np.concatenate([c.shapes.shapes_beside(f, offset[None]) for f in found.freedoms])
    felt = _felt(c, found.effect, psi.T)
    sizes = [v[0] + np.log(felt / _seen(c, o.effect, o.freedoms)) for o in others[:count]]
    return [(o, np.append(size, o.centre[1:])) for o, size in zip(others, sizes, strict=False)]


def _hanging(
    c: Compared, effect: str, group: tuple[Freedom, ...], tangents: Real, step: float, local: float, within: Real
) -> Callable[[Real, Compared], Change]:
    outputs, inputs = _numbers(c, group)
    at = [c.shapes.index(f) for f in group]
    seen, driven = c.shapes.seen[:, at].T, c.shapes.driven[:, at].T
    here = np.concatenate([c.shapes.shapes_beside(f, np.zeros((1, 3))) for f in group])

    def make(v: Real, _: Compared) -> Change:
        offset = v[1:3] @ tangents
        away = np.concatenate([c.shapes.shapes_beside(f, offset[None]) for f in group]) - here
        # Between the points the shapes are known within a deviation: the farther from them the less.
        uncertain = np.concatenate([c.shapes.uncertainty_beside(f, offset[None]) for f in group])
        away += v[5:].reshape(uncertain.shape) * uncertain
        size = _numbers_of(effect, float(np.exp(np.clip(v[0], *within))))
        return Change(
            AttachedElement(
                *_with_damping(c, effect, seen + away, driven + away),
                *size,
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
