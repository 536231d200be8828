"""What law a backbone is like, and at which point it acts: by the evidence of each law at each.

A nonlinear element at a point gives a mode the stiffness phi^2 k(a) and the damping phi^2 c(a), with phi the mode's
shape there and a the amplitude there. k and c are those of the first harmonic (Worden and Tomlinson, Nonlinearity in
Structural Dynamics, 2001, ch. 3; for joints Segalman, J. Appl. Mech. 72, 2005, 752). Two elements may act at one
place, as where a joint that slips closes. What none of them does is no known element.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from modallab.core.arrays import Real
from modallab.core.model import Backbone, ModalModel
from modallab.identification.backbone import backbone_notes

OFF = 0.05
"""By how much of its largest change a law is off, one deviation: no element follows it exactly."""
ANYHOW = 1.0
"""The same where no element is known: the numbers are anyhow within their range."""
PRIOR = {1: 0.8, 2: 0.1, 0: 0.1}
"""Probabilities of one element, of two, and of none that is known, before the comparison."""
GAPS = np.array([0.2, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0])
"""Clearances that are tried, over the median amplitude."""
POWERS = (0.25, 0.5, 1.0, 2.0)
"""Of the amplitude, in the loss of stiffness of a joint that slips at places."""
SLIPS = np.geomspace(0.05, 2.0, 8)
"""Amplitudes from which a joint slips as a whole, over the median amplitude."""
SAID = 0.9
"""Probability from which a law or a place is stated."""

Shape = Callable[[Real, Real], tuple[Real, Real]]
"""Amplitudes in m and omega in rad/s, both (modes, levels) -> stiffness of an element of unit size, and its damping
times omega."""


@dataclass(frozen=True, eq=False, slots=True)
class Law:
    """A family of elements.

    Attributes:
        name: in words.
        shapes: one for each of its inner numbers.
    """

    name: str
    shapes: tuple[Shape, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Hypothesis:
    """What may act at a place.

    Attributes:
        names: of the elements, in words.
        together: for each set of inner numbers the shapes of the elements that act together; () for none known.
        prior: probability.
    """

    names: tuple[str, ...]
    together: tuple[tuple[Shape, ...], ...]
    prior: float


@dataclass(frozen=True, eq=False, slots=True)
class LikelyLaw:
    """What the backbones are like.

    Attributes:
        laws: name -> probability that it acts, alone or with another; the most probable first.
        point: at which the most probable of all acts; None where the shapes do not show it.
        at_point: probability of that.
    """

    laws: dict[str, float]
    point: int | None
    at_point: float


def _clearance_law(gap: float) -> Shape:
    def shape(a: Real, _: Real) -> tuple[Real, Real]:
        share = np.minimum(gap * float(np.nanmedian(a)) / np.maximum(a, 1e-300), 1.0)
        return 1 - 2 / np.pi * (np.arcsin(share) + share * np.sqrt(1 - share**2)), 0 * a

    return shape


def _joint_law(power: float, ratio: float) -> Shape:
    return lambda a, _: (-(a**power), ratio * a**power)


def _slipping_law(limit: float) -> Shape:
    """A spring in series with dry friction (Jenkins)."""

    def shape(a: Real, _: Real) -> tuple[Real, Real]:
        share = np.minimum(limit * float(np.nanmedian(a)) / np.maximum(a, 1e-300), 1.0)
        angle = np.arccos(1 - 2 * share)
        return (angle - np.sin(2 * angle) / 2) / np.pi, 4 / np.pi * share * (1 - share)

    return shape


_JOINTS = (*(_joint_law(p, r) for p in POWERS for r in (0.1, 0.3, 1.0)), *(_slipping_law(float(x)) for x in SLIPS))


LAWS = (
    Law("a hardening spring", (lambda a, _: (a**2, 0 * a),)),
    Law("a softening spring", (lambda a, _: (-(a**2), 0 * a),)),
    Law("play between stops", tuple(_clearance_law(float(g)) for g in GAPS)),
    Law("a bolted joint", _JOINTS),
    Law("dry friction", (lambda a, _: (0 * a, 1 / a),)),
    Law("drag", (lambda a, omega: (0 * a, a * omega**2),)),
)
"""Each of one sign: what a spring, a joint or a damper of that kind can do."""


def _hypotheses() -> list[Hypothesis]:
    pairs = list(combinations(LAWS, 2))
    one = [Hypothesis((a.name,), tuple((s,) for s in a.shapes), PRIOR[1] / len(LAWS)) for a in LAWS]
    two = [Hypothesis((a.name, b.name), tuple(product(a.shapes, b.shapes)), PRIOR[2] / len(pairs)) for a, b in pairs]
    return [*one, *two, Hypothesis(("no known element",), ((),), PRIOR[0])]


HYPOTHESES = _hypotheses()


def likely_law(found: Backbone, model: ModalModel) -> LikelyLaw | None:
    """The laws with their probabilities; None where no mode was followed to three levels.

    Args:
        found: backbones of the model's modes.
        model: of the weakest level.
    """
    followed = np.isfinite(found.frequency_hz + found.damping_ratio + found.amplitude_m)
    known = np.asarray(np.all(followed, axis=1), np.bool_)
    if found.frequency_hz.shape[1] < 3 or not known.any():
        return None
    scores = {
        (one.names, point): np.logaddexp.reduce(
            [_evidence_of_elements(found, known, each, phi, at) for each in one.together]
        )
        + np.log(one.prior / len(one.together))
        for one in HYPOTHESES
        for point, phi, at in _places_of_element(found, model, known)
    }
    total = np.logaddexp.reduce(list(scores.values()))
    each = {key: float(np.exp(value - total)) for key, value in scores.items()}
    acts = {n: sum(p for (names, _), p in each.items() if n in names) for one in HYPOTHESES for n in one.names}
    first, point = max(each, key=lambda key: each[key])
    there = sum(p for (names, _), p in each.items() if names == first)
    return LikelyLaw(dict(sorted(acts.items(), key=lambda pair: -pair[1])), point, each[first, point] / there)


def level_notes(found: Backbone, model: ModalModel) -> tuple[str, ...]:
    """How each mode goes with its amplitude, and by which law; as `likely_law` takes them."""
    return (*backbone_notes(found), *law_note(likely_law(found, model)))


def law_note(likely: LikelyLaw | None) -> tuple[str, ...]:
    """A sentence on the law and its place, as far as they are known."""
    if likely is None:
        return ()
    stated = {name: p for name, p in likely.laws.items() if p >= SAID}
    if not stated:
        two = [f"{n} ({min(p, 0.99):.2f})" for n, p in list(likely.laws.items())[:2]]
        return (f"Its law stays open: {' or '.join(two)}.",)
    place = f" at point {likely.point}" if likely.point is not None and likely.at_point >= SAID else ""
    probability = min(*stated.values(), 0.99)
    return (
        f"The modes go with their amplitude as with {' and '.join(stated)}{place} (probability {probability:.2f}).",
    )


def _places_of_element(
    found: Backbone, model: ModalModel, known: NDArray[np.bool_]
) -> Iterator[tuple[int | None, Real, Real]]:
    """Points with (modes,) squares of the shapes there, and amplitudes there over those of the backbone."""
    rows = [model.outputs.index(name) for name in found.sensors]
    first = np.abs(model.modal_constants[:, :, 0])
    seen = first[np.arange(len(rows)), rows]
    driven = [o for o, p in enumerate(model.output_points) if p is not None and p == model.input_points[0]]
    if not driven or np.count_nonzero(known) < 2:
        yield None, np.ones(known.sum()), np.ones(known.sum())
        return
    for o, point in enumerate(model.output_points):
        yield point, (first[:, o] ** 2 / first[:, driven[0]])[known], (first[:, o] / seen)[known]


def _evidence_of_elements(
    found: Backbone, known: NDArray[np.bool_], shapes: tuple[Shape, ...], phi: Real, at: Real
) -> float:
    """Logarithm of the evidence of elements, each open up to where it alone would be all of the change."""
    omega = 2 * np.pi * found.frequency_hz[known]
    zeta, amplitude = found.damping_ratio[known], found.amplitude_m[known] * np.maximum(at, 1e-6)[:, None]
    values = np.stack([omega**2, 2 * zeta * omega**2])
    relative = 2 * found.frequency_sigma_hz[known] / found.frequency_hz[known], found.damping_sigma[known] / zeta
    # Stiffness and damping are the two parts of one complex number: what is off in one may be in the other.
    off = (OFF if shapes else ANYHOW) * np.ptp(values, axis=2, keepdims=True).max(axis=0)
    sigma = np.maximum(np.hypot(values * np.stack(relative), off), 1e-300)
    left = _without_mean(values, sigma)
    elements = [np.stack(shape(amplitude, omega)) * phi[:, None] for shape in shapes]
    cost = _least(left, [_without_mean(one, sigma) for one in elements])
    return float(-cost / 2 - np.sum(np.log(sigma)))


def _least(left: Real, elements: Sequence[Real]) -> float:
    """-2 ln of the evidence of what elements leave, each of open size up to where it alone is as large as `left`."""
    size = float(np.linalg.norm(left))
    if not elements:
        return size**2
    by = np.stack(elements, axis=1)
    by /= np.maximum(np.linalg.norm(by, axis=0), 1e-300)
    normal = by.T @ by + np.eye(len(elements)) / max(size, 1.0) ** 2
    rest, room = float(nnls(by, left)[1]), 2 * len(elements) * np.log(max(size, 1.0))
    return rest**2 + room + float(np.linalg.slogdet(normal)[1])


def _without_mean(values: Real, sigma: Real) -> Real:
    """In deviations, without each mode's own stiffness and damping, which are open: less their weighted means."""
    weight = 1 / sigma**2
    mean = np.sum(weight * values, axis=2, keepdims=True) / weight.sum(axis=2, keepdims=True)
    return np.asarray(((values - mean) / sigma).ravel(), np.float64)
