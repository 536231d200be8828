"""Even and odd distortions at lines that the drive leaves out: the levels of laws that have a closed form."""

import numpy as np
import pytest

from modallab.core.block import Block
from modallab.core.errors import DataError
from modallab.frf.undriven_lines import distortions_at_undriven_lines, has_undriven_lines
from modallab.identification.selection.assumptions import linearity_of_waves
from modallab.signals.signals import Signals

N, RATE_HZ = 512, 512.0
BAND = (1.0, 255.0)
ODD = np.arange(1, N // 2, 2)
TURNS = np.random.default_rng(5).permuted(np.tile(np.arange(4), (ODD.size // 4, 1)), axis=1).ravel()
"""In which of four waves each odd line is left out: at random, as a comb would favour some combinations of lines."""


def wave_of(number: int, lines: np.ndarray) -> np.ndarray:
    """These lines at random phases, of unit rms."""
    spectrum = np.zeros(N // 2 + 1, complex)
    spectrum[lines] = np.exp(2j * np.pi * np.random.default_rng(number).uniform(size=lines.size))
    wave = np.fft.irfft(spectrum, N)
    return wave / np.sqrt(np.mean(wave**2))


def blocks(law, waves: int = 8, noise: float = 0.01, grid=lambda w: ODD[w % 4 != TURNS]) -> list[Signals]:
    rng = np.random.default_rng(99)
    found = []
    for number in range(waves):
        force = wave_of(number, grid(number))
        for _ in range(2):
            answer = (law(force) + noise * rng.standard_normal(N))[None]
            block = Block(
                name=f"b{len(found)}", test="pseudo-random", order=len(found), rate_hz=RATE_HZ,
                samples=np.zeros((2, N)), scale=np.ones(2), units=("N", "m/s^2"), channels=("force", "a"),
            )  # fmt: skip
            found.append(Signals(forces=force, responses=answer, rate_hz=RATE_HZ, outputs=("a",), block=block))
    return found


def test_a_square_is_seen_at_even_lines_and_a_cube_at_odd_ones_each_at_its_level() -> None:
    """Of u + a u^2 + b u^3, u normal, 2 a^2 and 6 b^2 are left (Price); 3 of 4 odd lines are driven."""
    a, b = 0.02, 0.03
    found = distortions_at_undriven_lines(blocks(lambda u: u + a * u**2 + b * u**3), BAND)
    assert found.even[0] == pytest.approx(np.sqrt(2) * a / (1 + 3 * b), rel=0.1)
    assert found.odd[0] == pytest.approx(np.sqrt(0.75 * 6) * b / (1 + 3 * b), rel=0.1)
    assert 0 < found.odd_sigma[0] < 0.1 * found.odd[0]
    assert not linearity_of_waves(found).holds


def test_a_linear_structure_has_none_whatever_its_noise() -> None:
    found = distortions_at_undriven_lines(blocks(lambda u: u, noise=0.05), BAND)
    assert found.level[0] < 0.02
    assert found.noise_level[0] == pytest.approx(0.05 * np.sqrt(ODD.size * 0.75 / (N / 2)), rel=0.1)
    verdict = linearity_of_waves(found)
    assert verdict.holds
    assert "even" in verdict.words


def test_what_the_force_itself_holds_there_is_not_the_structures() -> None:
    given = blocks(lambda u: 2 * (u + 0.005 * u**2), noise=0.0)
    halved = [Signals(s.responses[0] / 2, s.responses, s.rate_hz, s.outputs, s.block) for s in given]
    assert distortions_at_undriven_lines(halved, BAND).level[0] < 1e-6


def test_a_drive_of_all_lines_leaves_none_out() -> None:
    every = blocks(lambda u: u, grid=lambda _: np.arange(1, N // 2))
    assert not has_undriven_lines(every, BAND)
    with pytest.raises(DataError, match="0 odd lines are driven by one wave and left out by another, 0 even"):
        distortions_at_undriven_lines(every, BAND)


def test_the_same_lines_left_out_by_every_wave_are_too_little() -> None:
    with pytest.raises(DataError, match="drive with detection_lines, four waves"):
        distortions_at_undriven_lines(blocks(lambda u: u, grid=lambda _: ODD[::2]), BAND)


def test_one_wave_is_too_little() -> None:
    with pytest.raises(DataError, match="1 different waves of two periods"):
        distortions_at_undriven_lines(blocks(lambda u: u, waves=1), BAND)
