"""Distortions of a cubic law, whose power has a closed form; none of a linear structure, whatever the noise."""

import numpy as np
import pytest

from modallab.core.block import Block
from modallab.core.errors import DataError
from modallab.frf.distortions import estimate_distortions
from modallab.identification.selection.assumptions import linearity_of_waves
from modallab.signals.signals import Signals

N, RATE_HZ = 512, 512.0
BAND = (1.0, 255.0)


def multisine(seed: int) -> np.ndarray:
    """All lines but 0 Hz and the highest, of random phases and unit rms."""
    spectrum = np.zeros(N // 2 + 1, complex)
    spectrum[1:-1] = np.exp(2j * np.pi * np.random.default_rng(seed).uniform(size=N // 2 - 1))
    wave = np.fft.irfft(spectrum, N)
    return wave / np.sqrt(np.mean(wave**2))


def blocks(law, waves: int = 8, periods: int = 2, noise: float = 0.01, test: str = "pseudo-random") -> list[Signals]:
    rng = np.random.default_rng(99)
    found = []
    for wave in range(waves):
        force = multisine(wave)
        for _ in range(periods):
            answer = np.stack([law(force), 2 * force]) + noise * rng.standard_normal((2, N))
            block = Block(
                name=f"b{len(found)}", test=test, order=len(found), rate_hz=RATE_HZ, samples=np.zeros((3, N)),
                scale=np.ones(3), units=("N", "m/s^2", "m/s^2"), channels=("force", "a", "b"),
            )  # fmt: skip
            found.append(Signals(forces=force, responses=answer, rate_hz=RATE_HZ, outputs=("a", "b"), block=block))
    return found


@pytest.mark.parametrize("a", [0.03, 0.1])
def test_the_level_of_a_cubic_law_is_that_of_its_closed_form(a: float) -> None:
    """Of u + a u^3 with normal u of unit power the best linear gain is 1 + 3 a, and 6 a^2 is left (Price's theorem)."""
    found = estimate_distortions(blocks(lambda u: u + a * u**3), BAND)
    assert found.level[0] == pytest.approx(np.sqrt(6) * a / np.hypot(1 + 3 * a, np.sqrt(6) * a), rel=0.1)
    assert np.mean(found.frf[0].real) == pytest.approx(1 + 3 * a, rel=0.02)
    assert (found.waves, found.periods) == (8, 2)
    assert linearity_of_waves(found).holds == (a < 0.02)


def test_the_noise_of_a_linear_structure_is_none() -> None:
    found = estimate_distortions(blocks(lambda u: u, noise=0.05), BAND)
    assert np.all(found.level < 0.01)
    assert found.noise_level[0] == pytest.approx(0.05, rel=0.1)
    assert linearity_of_waves(found).holds


def test_noise_that_hides_distortions_leaves_linearity_open() -> None:
    with pytest.raises(DataError, match="cannot be said"):
        linearity_of_waves(estimate_distortions(blocks(lambda u: u, waves=2, noise=0.5), BAND))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (blocks(lambda u: u, waves=1), "1 different waves"),
        (blocks(lambda u: u, periods=1), "of 1 periods"),
        (blocks(lambda u: u, test="random"), "no period"),
    ],
)
def test_what_shows_no_distortions_is_named(given: list[Signals], words: str) -> None:
    with pytest.raises(DataError, match=words):
        estimate_distortions(given, BAND)
