"""Several shakers at once, from their records to modes: against the closed form of each mode."""

import functools

import modal_bench as bench
import numpy as np
import pytest

import modallab as ml
from modallab.core.errors import DataError

RATE, SECONDS, BAND = 4000.0, 60.0, (3.0, 75.0)
SHAKERS = (5, 2)


@functools.cache
def recorded() -> tuple[bench.Modes, np.ndarray, np.ndarray]:
    """Modes, forces and accelerations at 1000 Hz; random forces to 100 Hz that share a half of their power."""
    rng = np.random.default_rng(4)
    system, n = bench.modes(rng), int(RATE * SECONDS)
    lines = np.fft.rfftfreq(n, 1 / RATE) < 100.0
    noise = np.fft.irfft(np.fft.rfft(rng.standard_normal((3, n))) * lines, n) * 50
    forces = noise[:2] + 0.7 * noise[2]
    answer = sum(bench.respond(system, force, point, RATE) for force, point in zip(forces, SHAKERS, strict=True))
    answer = answer + 1e-3 * answer.std() * rng.standard_normal(answer.shape)
    return system, forces[:, ::4], bench.lowpass(answer, 4)[:, : n // 4]


def test_two_shakers_at_once_give_the_modes_and_both_columns_of_their_constants() -> None:
    system, forces, answers = recorded()
    measured = ml.driven(forces, answers, RATE / 4, SHAKERS, band=BAND)
    model = ml.identify(measured).modal_model
    np.testing.assert_allclose(model.frequency_hz, system.frequency_hz[:2], rtol=1e-4)
    np.testing.assert_allclose(model.damping_ratio, system.zeta[:2], rtol=0.02)
    expected = system.phi[:2, :, None] * system.phi[:2, None, [p - 1 for p in SHAKERS]]
    np.testing.assert_allclose(model.modal_constants.real, expected, atol=0.03 * np.abs(expected).max())


@pytest.mark.parametrize("estimator", ["H1", "H2", "Hv"])
def test_averages_of_stretches_give_the_frfs_away_from_the_peaks(estimator: str) -> None:
    system, forces, answers = recorded()
    found = ml.driven(forces, answers, RATE / 4, SHAKERS, band=BAND, estimator=estimator, block_s=4.0).frf  # type: ignore[arg-type]
    s = 2j * np.pi * found.frequency_hz
    pole, shapes = 2 * np.pi * system.frequency_hz, system.phi
    modes = s**2 / (s**2 + 2 * (system.zeta * pole)[:, None] * s + pole[:, None] ** 2)
    true = np.einsum("mo,mi,ml->oil", shapes, shapes[:, [p - 1 for p in SHAKERS]], modes)
    flat = np.all(np.abs(found.frequency_hz / system.frequency_hz[:2, None] - 1) > 0.15, axis=0)
    off = np.abs(found.values - true)[..., flat] / np.sqrt(np.mean(np.abs(true[..., flat]) ** 2))
    assert np.sqrt(np.mean(off**2)) < 0.03


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"forces": lambda f: np.stack([f[0], f[0]])}, "cannot be distinguished"),
        ({"forces": lambda f: f[:, :-1]}, "have 59999 samples"),
        ({"band": (3.0, 200.0)}, "has no content at"),
        ({"band": (30.0, 30.05)}, "lines"),
        ({"estimator": "H3"}, "no estimator is called"),
        ({"estimator": "H1"}, "whose length is not given"),
    ],
)
def test_records_that_cannot_be_used_say_why(change: dict, said: str) -> None:
    _, forces, answers = recorded()
    given = {"band": BAND} | {k: v for k, v in change.items() if k != "forces"}
    with pytest.raises(DataError, match=said):
        ml.driven(change.get("forces", lambda f: f)(forces), answers, RATE / 4, SHAKERS, **given)
