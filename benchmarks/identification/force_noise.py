"""A random test with noise on the force channel: how many 95 % intervals hold the truth, by H1, H2 and Hv.

    python benchmarks/identification/force_noise.py --seeds 30 [--noise 0 0.05 0.1 0.2] [--seconds 30]

Modes at 60 Hz, 1 % and 140 Hz, 0.8 %, three points, driven at the first; the responses are exact for the force but for
noise of 0.1 %. For each level and estimator it prints the share of intervals of frequencies, damping ratios and modal
constants, and the mean error of the constants in percent.
"""

import argparse

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign
from modallab.core.rig import Channel, Point, Rig
from modallab.core.units import FRF_ESTIMATORS, FrfEstimator
from modallab.identification.options import Options
from modallab.pipelines.identify import identify_campaign

RATE_HZ, HZ, ZETA = 1024.0, np.array([60.0, 140.0]), np.array([0.01, 0.008])
PHI = np.array([[1.0, 0.8], [0.6, -0.9], [-0.5, 0.4]])
NAMES = ("force", "a1", "a2", "a3")
RIG = Rig(
    name="three points",
    model="unknown",
    points=tuple(Point(id=k, x_m=0.1 * k) for k in (1, 2, 3)),
    channels=(
        Channel(index=0, name="force", quantity="force", unit="N", point=1),
        *(Channel(index=k, name=f"a{k}", quantity="acceleration", unit="m/s^2", point=k) for k in (1, 2, 3)),
    ),
)


def campaign(noise: float, seed: int, seconds: float) -> Campaign:
    """One record of random drive; the force is periodic in it, so that nothing rings at its ends."""
    rng, n = np.random.default_rng(seed), int(seconds * RATE_HZ)
    force = rng.normal(size=n)
    omega, w = 2 * np.pi * np.fft.rfftfreq(n, 1 / RATE_HZ), 2 * np.pi * HZ[:, None]
    modes = -(omega**2) / (w**2 - omega**2 + 2j * ZETA[:, None] * w * omega)
    responses = np.fft.irfft((PHI * PHI[0]) @ modes * np.fft.rfft(force), n)
    responses += 1e-3 * responses.std() * rng.normal(size=responses.shape)
    samples = np.vstack([force + noise * rng.normal(size=n), responses])
    units = ("N", *["m/s^2"] * 3)
    block = Block("run", "random", 0, RATE_HZ, samples, np.ones(4), units, NAMES, drive_point=1)
    return Campaign(RIG, (block,))


def errors(measured: Campaign, how: FrfEstimator) -> tuple[NDArray[np.float64], float]:
    """Errors of frequencies, damping and constants in sigmas, three rows; and the constants' mean error."""
    (found,) = identify_campaign(measured, Options(frf=how)).identified
    model = found.model
    if model.n_modes != HZ.size:
        return np.full((3, 2), np.nan), np.nan
    constants, true = model.modal_constants[:, 0, 0].real, PHI[0] ** 2
    sigma = model.modal_constant_sigma[:, 0, 0]
    if model.modal_constant_part_sigma is not None:
        sigma = model.modal_constant_part_sigma[:, 0, 0].real
    rows = (
        (model.frequency_hz - HZ) / model.frequency_sigma_hz,
        (model.damping_ratio - ZETA) / model.damping_sigma,
        (constants - true) / sigma,
    )
    return np.array(rows), float(np.mean(constants / true - 1))


def main() -> None:
    """Print a line for each level of noise and estimator."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--noise", type=float, nargs="+", default=[0.0, 0.05, 0.1, 0.2])
    parser.add_argument("--seconds", type=float, default=30.0)
    asked = parser.parse_args()
    for noise in asked.noise:
        for how in FRF_ESTIMATORS:
            parts = [errors(campaign(noise, seed, asked.seconds), how) for seed in range(asked.seeds)]
            away = np.array([rows for rows, _ in parts])
            held = np.nanmean(np.abs(away) < 1.96, axis=(0, 2))
            lost = int(np.isnan(away[:, 0, 0]).sum())
            bias = 100 * float(np.nanmean([one for _, one in parts]))
            shares = ", ".join(f"{name} {share:.2f}" for name, share in zip(("f", "zeta", "A"), held, strict=True))
            print(f"noise {noise:g}, {how}: held {shares}; A off {bias:+.2f} %; {lost} of {asked.seeds} lost")


if __name__ == "__main__":
    main()
