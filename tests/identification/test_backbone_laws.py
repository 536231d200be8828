"""Laws of an element at one of three points, by their first harmonics: family and place, and no more than is known."""

from collections.abc import Callable

import numpy as np
import pytest
from phased_line import OMEGA, PSI, ZETA, model

from modallab.core.model import Backbone
from modallab.identification.backbone_laws import law_note, likely_law

Element = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
OWN = np.argmax(np.abs(PSI), axis=1)


def joint(a: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of Jenkins: a spring of 20 kN/m that slips from 0.1 mm on; amplitudes below have no slip."""
    over = np.maximum(a / 1e-4, 1.0)
    angle = np.arccos(1 - 2 / over)
    return 2e4 / np.pi * (angle - np.sin(2 * angle) / 2), 8e4 * (over - 1) / np.pi / over**2 / omega


def play(a: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Stops of 5 kN/m at 0.06 mm."""
    share = np.minimum(6e-5 / a, 1.0)
    return 5e3 * (1 - 2 / np.pi * (np.arcsin(share) + share * np.sqrt(1 - share**2))), 0 * omega


LAWS = {
    "a hardening spring": lambda a, _: (0.75 * 3e9 * a**2, 0 * a),
    "a softening spring": lambda a, _: (-0.75 * 5e9 * a**2, 0 * a),
    "play between stops": play,
    "a bolted joint": joint,
    "dry friction": lambda a, omega: (0 * a, 0.2 / np.pi / omega / a),
    "drag": lambda a, omega: (0 * a, 8 / 3 / np.pi * 2e3 * omega * a),
}


def backbone(law: str | Element, point: int, seed: int, levels: int = 5) -> Backbone:
    acts = LAWS[law] if isinstance(law, str) else law
    rng, level = np.random.default_rng(seed), np.geomspace(1e-4, 1e-3, levels)
    motion, omega = level * np.array([[3.0], [1.0], [0.6]]), OMEGA[:, None]
    there = PSI[:, [point - 1]]
    stiffness, damper = acts(np.abs(there) * motion, omega)
    squared = omega**2 + there**2 * stiffness
    zeta = (2 * ZETA[:, None] * omega + there**2 * damper) / 2 / np.sqrt(squared)
    hz = np.sqrt(squared) / (2 * np.pi)
    return Backbone(
        levels=tuple(str(n) for n in range(levels)),
        sensors=tuple(f"a{n + 1}" for n in OWN),
        amplitude_m=np.abs(PSI[np.arange(3), OWN])[:, None] * motion,
        frequency_hz=hz * (1 + 2e-5 * rng.standard_normal(hz.shape)),
        frequency_sigma_hz=2e-5 * hz,
        damping_ratio=zeta * (1 + 0.02 * rng.standard_normal(hz.shape)),
        damping_sigma=0.02 * zeta,
    )


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("point", [1, 2, 3])
def test_no_other_law_is_stated_and_no_other_place(law: str, point: int) -> None:
    likely = likely_law(backbone(law, point, seed=point), model())
    assert likely is not None
    (note,) = law_note(likely)
    assert law in note
    assert "at point" not in note or f"at point {point} " in note


@pytest.mark.parametrize("law", ["a bolted joint", "play between stops", "drag"])
def test_a_law_that_moves_the_modes_much_is_stated_with_its_place(law: str) -> None:
    (note,) = law_note(likely_law(backbone(law, 2, seed=9), model()))
    assert note.startswith(f"The modes go with their amplitude as with {law} at point 2 (probability 0.9")


def test_a_joint_that_closes_is_both() -> None:
    """As of bolted beams: the frequency falls and rises again, and the damping rises throughout."""

    def closes(a: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return -8e5 * a**0.5 + 5e10 * a**2, 4e5 * a**0.5 / omega

    (note,) = law_note(likely_law(backbone(closes, 2, seed=4, levels=8), model()))
    assert "a hardening spring" in note
    assert "a bolted joint" in note
    assert " and " in note


def test_what_no_element_does_is_none_of_them() -> None:
    def swings(a: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        turned = 6 * np.log(a / a.min())
        return 4e3 * np.sin(turned), 4e3 * (1 + np.cos(turned)) / omega

    (note,) = law_note(likely_law(backbone(swings, 2, seed=5, levels=8), model()))
    assert "as with no known element" in note


def test_two_levels_show_no_law() -> None:
    assert likely_law(backbone("drag", 1, seed=1, levels=2), model()) is None
