"""A roving test whose set-ups disagree: 80 points and 3 sensors, 20 modes, some of them close; the truth is known.

    python benchmarks/identification/roving.py --scatter 0.01 0.05 0.2 --repeats 3

Every point (or patch of points, --patch) is a set-up of its own, in which each frequency is off by a normal deviate of
so many per cent, common to all modes in half of its variance, and each damping ratio by 30 times as much. `--transpose`
hits the 80 points and keeps the 3 sensors. It prints modes found, spurious ones, how often 95 % intervals of f and zeta
hold the truth, and the time; and how often Student's intervals of the set-ups' true poles would: few set-ups of a few
repeats are off by more or less, however well each is known.
"""

import argparse
import time

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from modallab.core.errors import ModallabError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Rig
from modallab.identification.frf_model import identify_frf
from modallab.identification.options import IdentificationOptions

Real = NDArray[np.float64]
SAME = 0.003
"""A mode within this share of a true frequency is that mode, each taken once."""
ZETA_SCATTER = 30.0


def truth(rng: np.random.Generator, n_modes: int = 20) -> tuple[Real, Real]:
    """Frequencies in Hz, a third of them within a per cent of their neighbour, and damping ratios."""
    f = np.linspace(100, 900, n_modes) * rng.uniform(0.98, 1.02, n_modes)
    for k in range(1, n_modes, 3):
        f[k] = f[k - 1] * (1 + rng.uniform(0.006, 0.012))
    return np.sort(f), rng.uniform(0.001, 0.004, n_modes)


def measured(
    rng: np.random.Generator, f: Real, zeta: Real, scatter: float, points: int, patch: int, transpose: bool
) -> tuple[Frf, Real]:
    """Inertances (points, 3) with noise of 1e-3 of the level, and what each set-up is off: (set-ups, 2, modes)."""
    lines = np.arange(60.0, 960.0, 0.25)
    phi = rng.normal(size=(f.size, points + 3)) * (1 + rng.uniform(0, 1, (f.size, 1)))
    s, values = 2j * np.pi * lines, np.zeros((points, 3, lines.size), complex)
    all_off: list[Real] = []
    for first in range(0, points, patch):
        here = slice(first, first + patch)
        off = scatter / 100 * (rng.normal() + rng.normal(size=f.size)) / np.sqrt(2)
        w = 2 * np.pi * f * (1 + off)
        off_zeta = ZETA_SCATTER * scatter / 100 * rng.normal(size=f.size)
        z = zeta * (1 + off_zeta)
        all_off.append(np.stack([off, off_zeta]))
        per_mode = s**2 / (s**2 + 2 * z[:, None] * w[:, None] * s + w[:, None] ** 2)
        values[here] = np.einsum("mo,mi,ml->oil", phi[:, :points][:, here], phi[:, points:], per_mode)
    level = 1e-3 * np.sqrt(np.mean(np.abs(values) ** 2))
    values += level * (rng.normal(size=values.shape) + 1j * rng.normal(size=values.shape)) / np.sqrt(2)
    if transpose:
        values = values.transpose(1, 0, 2)
    n_out, n_in = values.shape[:2]
    frf = Frf(
        frequency_hz=lines,
        values=values,
        quantity="inertance",
        outputs=tuple(f"a{o}" for o in range(n_out)),
        output_points=tuple(range(1, n_out + 1)) if not transpose else tuple(range(101, 101 + n_out)),
        input_points=tuple(range(101, 101 + n_in)) if not transpose else tuple(range(1, n_in + 1)),
    )
    return frf, np.array(all_off)


def held_by_true_poles(off: Real) -> tuple[list[bool], list[bool]]:
    """Which of Student's intervals of f and of zeta hold the truth, if the poles of every set-up were known exactly."""
    n = len(off)
    if n < 2 or not off.any():
        return [], []
    t = off.mean(axis=0) / (off.std(axis=0, ddof=1) / np.sqrt(n))
    in_f, in_zeta = (np.abs(t) < stats.t.ppf(0.975, n - 1)).tolist()
    return in_f, in_zeta


def rig_of(frf: Frf) -> Rig:
    """Force and the FRF's outputs, at no known points."""
    force = Channel(index=0, name="force", quantity="force", unit="N")
    rest = [Channel(index=i, name=n, quantity="acceleration", unit="m/s^2") for i, n in enumerate(frf.outputs, 1)]
    return Rig(name="roving", model="unknown", channels=(force, *rest))


def score(model: ModalModel, f: Real, zeta: Real) -> tuple[int, int, list[bool], list[bool]]:
    """Modes found, spurious ones, and which intervals hold."""
    left, in_f, in_zeta = list(range(model.n_modes)), [], []
    for fr, zr in zip(f, zeta, strict=True):
        near = [r for r in left if abs(model.frequency_hz[r] / fr - 1) < SAME]
        if near:
            r = min(near, key=lambda k: abs(model.frequency_hz[k] - fr))
            left.remove(r)
            in_f.append(abs(model.frequency_hz[r] - fr) < 1.96 * model.frequency_sigma_hz[r])
            in_zeta.append(abs(model.damping_ratio[r] - zr) < 1.96 * model.damping_sigma[r])
    return len(in_f), len(left), in_f, in_zeta


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scatter", type=float, nargs="+", default=[0.0, 0.01, 0.05, 0.2])
    parser.add_argument("--points", type=int, default=80)
    parser.add_argument("--modes", type=int, default=20)
    parser.add_argument("--patch", type=int, default=1)
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--transpose", action="store_true")
    a = parser.parse_args()
    for scatter in a.scatter:
        in_f: list[bool] = []
        in_zeta: list[bool] = []
        ideal_f: list[bool] = []
        ideal_zeta: list[bool] = []
        for seed in range(a.repeats):
            rng = np.random.default_rng(seed)
            f, zeta = truth(rng, a.modes)
            frf, off = measured(rng, f, zeta, scatter, a.points, a.patch, a.transpose)
            begin = time.process_time()
            try:
                model, _ = identify_frf(frf, rig_of(frf), IdentificationOptions())
            except ModallabError as error:
                print(f"scatter {scatter} % seed {seed}: {error}", flush=True)
                continue
            found, spurious, one, other = score(model, f, zeta)
            in_f += one
            in_zeta += other
            for held, more in zip((ideal_f, ideal_zeta), held_by_true_poles(off), strict=True):
                held += more
            took = time.process_time() - begin
            held = f"{sum(one)} and {sum(other)} of {found} intervals hold"
            print(
                f"{scatter} % seed {seed}: {found} of {f.size} modes, {spurious} spurious, {held}, {took:.0f} s",
                flush=True,
            )
        if in_f:
            print(
                f"scatter {scatter} %: in 95 % intervals f {np.mean(in_f):.3f}, zeta {np.mean(in_zeta):.3f}", flush=True
            )
        if ideal_f:
            print(f"  of exactly known set-ups f {np.mean(ideal_f):.3f}, zeta {np.mean(ideal_zeta):.3f}", flush=True)


if __name__ == "__main__":
    main()
