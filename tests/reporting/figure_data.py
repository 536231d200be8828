"""A closed-form cantilever whose tests, model and verification are known: input of the figure tests."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign
from modallab.core.frf import Frf
from modallab.core.model import ModalModel, Verification
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.reporting.content import OutcomeOfTest, ReportContent, ReportedHit, TrueModes
from modallab.signals.signals import Signals

POINTS = tuple(range(1, 11))
FREQUENCY = np.array([4.803, 30.86, 87.92])
DAMPING = np.array([0.0051, 0.0074, 0.0038])
LENGTH_M, MASS_KG = 0.887, 1.42
NOISE = 0.02


def rig(**changes: object) -> Rig:
    sensor = {"quantity": "acceleration", "unit": "m/s^2", "sensitivity_v_per_unit": {"impact": 0.01, "sine": 0.1}}
    channels = [
        {
            "index": 0,
            "name": "force",
            "quantity": "force",
            "unit": "N",
            "serial": "F-208C",
            "calibrated_on": "2024-02-13",
            "sensitivity_v_per_unit": {"impact": 0.02, "sine": 0.5},
        }
    ]
    channels += [
        {"index": i, "name": f"a{i:02d}", "point": i, "serial": f"A-{700 + i}", "calibrated_on": "2024-03-07", **sensor}
        for i in POINTS
    ]
    document = {
        "name": "elastic link",
        "beam": {
            "length_m": LENGTH_M,
            "width_m": 0.0511,
            "thickness_m": 0.00399,
            "youngs_modulus_pa": 205e9,
            "density_kg_m3": 7850.0,
        },
        "points": [{"id": i, "x_m": LENGTH_M * i / 10} for i in POINTS],
        "channels": channels,
        "converter": {},
        "shaker_point": 4,
    }
    return Rig.model_validate(document | changes)


def shapes() -> NDArray[np.float64]:
    """(3, 10) shapes of a clamped-free beam at unit modal mass, the tip positive."""
    beta = np.array([1.87510407, 4.69409113, 7.85475744])[:, None]
    s = (np.cosh(beta) + np.cos(beta)) / (np.sinh(beta) + np.sin(beta))
    z = beta * np.arange(1, 11) / 10
    phi = np.cosh(z) - np.cos(z) - s * (np.sinh(z) - np.sin(z))
    return phi * np.sign(phi[:, -1:]) / np.sqrt(MASS_KG)


def inertance(
    frequency_hz: NDArray[np.float64], drive: int, zeta: NDArray[np.float64] = DAMPING
) -> NDArray[np.complex128]:
    """(10, lines) sum of the modes, and the stiffness of all higher ones."""
    phi, w = shapes(), 2 * np.pi * frequency_hz
    wr = 2 * np.pi * FREQUENCY[:, None]
    receptance = 1 / (wr**2 - w**2 + 2j * zeta[:, None] * wr * w)
    return -(w**2) * np.einsum("ro,rl->ol", phi * phi[:, drive - 1 : drive], receptance)


def impact(seed: int, drive: int = 6, peak_n: float = 70.0) -> Signals:
    rng = np.random.default_rng(seed)
    rate, n, long = 2000.0, 2048, 1 << 17
    t = np.arange(n) / rate
    contact = 0.004
    force = np.where((t > 0.05) & (t < 0.05 + contact), peak_n * np.sin(np.pi * (t - 0.05) / contact), 0.0)
    lines = np.fft.rfftfreq(long, 1 / rate)
    response = np.fft.irfft(inertance(lines, drive) * np.fft.rfft(force, long), axis=1)[:, :n]
    return signals("impact", f"impact_{seed:03d}", seed, rate, force, response, drive, rng)


def sine(frequency_hz: float, order: int, drive: int = 4) -> Signals:
    rng = np.random.default_rng(order)
    rate, n = 1000.0, 1024
    t = np.arange(n) / rate
    force = 1.2 * np.sin(2 * np.pi * frequency_hz * t)
    amplitude = 1.2 * inertance(np.array([frequency_hz]), drive)
    response = np.imag(amplitude * np.exp(2j * np.pi * frequency_hz * t))
    return signals("sine", f"sine_{order:03d}", order, rate, force, response, drive, rng, frequency_hz)


def signals(test: Test, name: str, order: int, rate: float, force: NDArray[np.float64],
            response: NDArray[np.float64], drive: int, rng: np.random.Generator,
            frequency_hz: float | None = None) -> Signals:  # fmt: skip
    force = force + NOISE * rng.standard_normal(force.shape)
    response = response + NOISE * rng.standard_normal(response.shape)
    names = tuple(f"a{i:02d}" for i in POINTS)
    samples = np.vstack([force, response])
    block = Block(name, test, order, rate, samples, np.ones(11), ("N", *["m/s^2"] * 10), ("force", *names), drive,
                  frequency_hz=frequency_hz, requested_rate_hz=rate, actual_rate_hz=rate)  # fmt: skip
    return Signals(force, response, rate, names, block)


def measured(blocks: list[Signals]) -> Frf:
    """H1 inertance of several hits on one point."""
    f = np.fft.rfft([s.force for s in blocks], axis=-1)
    x = np.fft.rfft([s.responses for s in blocks], axis=-1)
    lines = np.fft.rfftfreq(blocks[0].force.size, 1 / blocks[0].rate_hz)
    sff = (np.abs(f) ** 2).sum(0)
    sfx = (f.conj()[:, None] * x).sum(0)
    sxx = (np.abs(x) ** 2).sum(0)
    coherence = np.abs(sfx) ** 2 / (sff * sxx)
    keep = (lines >= 2.9) & (lines <= 110)
    return frf(
        lines[keep], (sfx / sff)[:, keep], "inertance", blocks[0].block.drive_point, coherence[:, keep], len(blocks)
    )


def frf(lines, values, quantity, drive, coherence=None, averages=1) -> Frf:
    names = tuple(f"a{i:02d}" for i in POINTS)
    shaped = None if coherence is None else coherence[:, None, :]
    return Frf(lines, values[:, None, :], quantity, names, POINTS, (drive,), shaped, None, (averages,))


def verification(blocks: list[Signals]) -> Verification:
    """Measured against the same hits without noise: what a true model gives through the same block."""
    seen = measured(blocks)
    drive = blocks[0].block.drive_point or 1
    s = 2j * np.pi * seen.frequency_hz
    clean = [_clean(b, drive) for b in blocks]
    again = measured(clean)
    fine = np.linspace(3, 110, 3000)
    a, b = seen.values / s, again.values / s * 1.002
    frac = np.abs((a * b.conj()).sum(-1)) ** 2 / ((np.abs(a) ** 2).sum(-1) * (np.abs(b) ** 2).sum(-1))
    mobility = {"quantity": "mobility"}
    return Verification(
        replace(seen, values=a, **mobility),
        replace(again, values=b, **mobility),
        frf(fine, inertance(fine, drive) / (2j * np.pi * fine), "mobility", drive),
        frac,
    )


def _clean(block: Signals, drive: int) -> Signals:
    rate, n, long = block.rate_hz, block.force.size, 1 << 17
    lines = np.fft.rfftfreq(long, 1 / rate)
    response = np.fft.irfft(inertance(lines, drive) * np.fft.rfft(block.force, long), axis=1)[:, :n]
    return replace(block, responses=response)


def sine_verification(frequencies: list[float], drive: int = 4) -> Verification:
    lines = np.array(frequencies)
    rng = np.random.default_rng(5)
    b = inertance(lines, drive) / (2j * np.pi * lines)
    a = b * (1 + 0.01 * (rng.standard_normal(b.shape) + 1j * rng.standard_normal(b.shape)))
    fine = np.linspace(3, 110, 3000)
    frac = np.abs((a * b.conj()).sum(-1)) ** 2 / ((np.abs(a) ** 2).sum(-1) * (np.abs(b) ** 2).sum(-1))
    return Verification(
        frf(lines, a, "mobility", drive),
        frf(lines, b, "mobility", drive),
        frf(fine, inertance(fine, drive) / (2j * np.pi * fine), "mobility", drive),
        frac[:, None],
    )


def model(test: Test = "impact", seed: int = 3, drive: int = 6, **changes: object) -> ModalModel:
    rng = np.random.default_rng(seed)
    f_sigma = np.array([2e-4, 1.1e-3, 2.4e-3]) * (1 if test == "impact" else 4)
    z_sigma = DAMPING * np.array([0.012, 0.006, 0.004]) * (1 if test == "impact" else 2)
    phi = shapes()
    phi_sigma = np.full(phi.shape, 0.004)
    noisy = phi + phi_sigma * rng.standard_normal(phi.shape)
    constants = noisy[:, :, None] * noisy[:, drive - 1, None, None] + 0j
    floor = 0.32 / FREQUENCY
    values: dict[str, object] = {
        "method": "plscf",
        "test": test,
        "band_hz": (3.0, 110.0),
        "frequency_hz": FREQUENCY + f_sigma * rng.standard_normal(3),
        "damping_ratio": DAMPING + z_sigma * rng.standard_normal(3),
        "frequency_sigma_hz": f_sigma,
        "damping_sigma": z_sigma,
        "outputs": tuple(f"a{i:02d}" for i in POINTS),
        "output_points": POINTS,
        "input_points": (drive,),
        "modal_constants": constants,
        "modal_constant_sigma": np.full(constants.shape, 0.006),
        "residuals": np.full((1, 10, 1), 2e-6),
        "residual_powers": (0,),
        "shapes": noisy + 0j,
        "shape_sigma": phi_sigma,
        "half_power": floor * np.array([1.01, 1.06, 1.12]),
        "half_power_floor": floor,
    }
    return ModalModel.model_validate(values | changes)


FREQUENCIES = [
    n / 1.024 for n in (3, 4, 5, 6, 8, 12, 18, 24, 28, 30, 31, 32, 33, 35, 40, 50, 60, 72, 84, 88, 90, 92, 96, 108)
]


def content(**changes: object) -> ReportContent:
    """Both tests, all there is to report."""
    impacts = [impact(i) for i in range(1, 6)]
    bursts = [sine(f, 10 + i) for i, f in enumerate(FREQUENCIES)]
    hits = [ReportedHit(s.block.name, 6, s.force, s.rate_hz) for s in impacts]
    hits.insert(
        2, ReportedHit("rejected_1", 6, impact(77, peak_n=6.0).force, 2000.0, False, "peak force 6.0 N is below 10 N")
    )
    double = impact(78).force + np.roll(impact(79, peak_n=18.0).force, 60)
    hits.insert(4, ReportedHit("rejected_2", 6, double, 2000.0, False, "a second hit of 18.0 N, 30 ms after the first"))
    campaign = Campaign(
        rig(), tuple(s.block for s in impacts + bursts), provenance={"plan": "demo"}, source="demo/campaign.h5"
    )
    example = impacts[0]
    window = np.fft.rfft(example.responses, axis=1)
    lines = np.fft.rfftfreq(example.force.size, 1 / example.rate_hz)
    window[:, (lines < 3) | (lines > 110)] *= 1e-3
    outcomes = (
        OutcomeOfTest("impact", model(), measured(impacts), verification(impacts), example,
                np.fft.irfft(window, axis=1), tuple(hits)),
        OutcomeOfTest("sine", model("sine", 4, 4), None, sine_verification(FREQUENCIES), bursts[8]),
    )  # fmt: skip
    values: dict[str, object] = {
        "title": "Modal test of the elastic link",
        "campaign": campaign,
        "outcomes": outcomes,
        "truth": TrueModes(FREQUENCY, DAMPING, "the simulated bench, seed 1"),
        "notes": ("The bench is simulated.",),
        "provenance": {"modallab": "0.1.0", "seed": "1", "rig hash": "5f2a9c" * 8, "made at": "2024-05-31 14:05 UTC"},
    }
    return ReportContent(**(values | changes))
