"""Responses alone: a cantilever under white noise at one point, ten accelerometers, the truth is known.

    python benchmarks/identification/response_only.py --repeats 20 [--method plscf_spectra]

Modes are those of a clamped beam with its first at 4.75 Hz, damped as that of the demonstration; each answers the noise
exactly from sample to sample. For every mode it prints how often it was found, the error of frequency and damping (rms
over the seeds), what no estimator can do better than (Cramer and Rao, one mode alone, no noise), and how often 95 %
intervals hold the truth.
"""

import argparse

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from modallab.core.errors import ModallabError
from modallab.identification.response_only.modes import response_modes
from modallab.pipelines.response_only import POLES

Real = NDArray[np.float64]

FREQUENCY_HZ = np.array([4.755, 30.59, 87.15, 173.0, 288.9, 434.9, 611.2])
ZETA = np.array([0.00614, 0.00602, 0.00594, 0.00494, 0.00875, 0.00335, 0.00365])
ROOTS = np.array([1.87510407, 4.69409113, 7.85475744, 10.9955407, 14.1371684, 17.2787595, 20.4203523])
SAME = 0.01


def shape(x: Real) -> Real:
    """(modes, places) of a clamped and free beam at these shares of its length."""
    b = ROOTS[:, None] * x
    ratio = (np.cosh(ROOTS) + np.cos(ROOTS)) / (np.sinh(ROOTS) + np.sin(ROOTS))
    return np.cosh(b) - np.cos(b) - ratio[:, None] * (np.sinh(b) - np.sin(b))


def responses(seed: int, seconds: float, rate_hz: float, sensors: int = 10, noise: float = 1e-3) -> Real:
    """Accelerations (sensors, samples) under white noise at 0.3 of the length."""
    rng = np.random.default_rng(seed)
    warm = int(30 * rate_hz)
    force = rng.standard_normal(int(seconds * rate_hz) + warm)
    phi, drive = shape(np.linspace(1 / sensors, 1, sensors)), shape(np.array([0.3]))[:, 0]
    y = np.zeros((sensors, force.size))
    for r, (f, zeta) in enumerate(zip(FREQUENCY_HZ, ZETA, strict=True)):
        omega = 2 * np.pi * f
        pole = omega * (-zeta + 1j * np.sqrt(1 - zeta**2))
        # The acceleration's part that answers after the force: residue lambda^2 / (2 j omega_d), both of the pair.
        z, residue = np.exp(pole / rate_hz), pole**2 / (2j * pole.imag) / rate_hz
        a = [1, -2 * z.real, abs(z) ** 2]
        b = [2 * residue.real, -2 * (residue * z.conjugate()).real]
        y += np.outer(phi[r] * drive[r], lfilter(b, a, force))
    y = y[:, warm:]
    return y + noise * np.sqrt(np.mean(y**2)) * rng.standard_normal(y.shape)


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--rate", type=float, default=2000.0)
    parser.add_argument("--method", choices=POLES, default="ssi_cov")
    a = parser.parse_args()
    n = FREQUENCY_HZ.size
    errors: list[list[tuple[float, float, bool, bool]]] = [[] for _ in range(n)]
    spurious = 0
    for seed in range(a.repeats):
        try:
            found = response_modes([responses(seed, a.seconds, a.rate)], a.rate, (3.0, 750.0), POLES[a.method])
        except ModallabError as error:
            print(f"seed {seed}: {error}", flush=True)
            continue
        left = list(range(found.frequency_hz.size))
        for r in range(n):
            near = [k for k in left if abs(found.frequency_hz[k] / FREQUENCY_HZ[r] - 1) < SAME]
            if near:
                k = min(near, key=lambda i: abs(found.frequency_hz[i] - FREQUENCY_HZ[r]))
                left.remove(k)
                f, zeta = found.frequency_hz[k] - FREQUENCY_HZ[r], found.damping_ratio[k] - ZETA[r]
                held = abs(f) < 1.96 * found.frequency_sigma_hz[k], abs(zeta) < 1.96 * found.damping_sigma[k]
                errors[r].append((f / FREQUENCY_HZ[r], zeta / ZETA[r], *held))
        spurious += len(left)
    alpha = 2 * np.pi * FREQUENCY_HZ * ZETA
    bound = np.sqrt(1 / (alpha * a.seconds))
    print("  Hz       found  f [%]   bound  zeta [%]  bound  held f  held zeta")
    for r in range(n):
        e = np.array(errors[r], dtype=np.float64).reshape(-1, 4)
        rms = 100 * np.sqrt(np.mean(e[:, :2] ** 2, axis=0))
        print(
            f"{FREQUENCY_HZ[r]:8.3f} {len(e):4d}/{a.repeats} {rms[0]:7.4f} {100 * bound[r] * ZETA[r]:7.4f}"
            f" {rms[1]:8.2f} {100 * bound[r]:7.2f} {e[:, 2].mean():7.2f} {e[:, 3].mean():7.2f}"
        )
    every = np.concatenate([np.array(e).reshape(-1, 4) for e in errors])
    print(f"all: intervals hold f {every[:, 2].mean():.3f}, zeta {every[:, 3].mean():.3f}; {spurious} spurious")


if __name__ == "__main__":
    main()
