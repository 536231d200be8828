"""FRFs of two sensors: modes that one alone finds and both lose, and the same FRFs in three quantities.

    python benchmarks/identification/one_and_both.py --structures 20 [--first 300]

Each structure has 3 to 6 modes of 0.3 to 2 % between 15 and 180 Hz, and noise even in the acceleration, another for
each sensor. Prints the modes lost, and how far the quantities are apart in sigma.
"""

import argparse

import numpy as np
from numpy.typing import NDArray

import modallab as ml
from modallab.core.errors import ModallabError
from modallab.core.model import ModalModel

LINES = np.arange(5, 200, 0.25)
OMEGA = 2 * np.pi * LINES
SAME = 3e-3


def structure(seed: int) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
    """Natural frequencies in Hz, and inertances (2, 1, lines)."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 7))
    hz = np.sort(rng.uniform(15, 180, count))
    while np.any(np.diff(hz) < 5):
        hz = np.sort(rng.uniform(15, 180, count))
    zeta, phi = rng.uniform(0.003, 0.02, count), rng.normal(size=(2, count))
    phi[0] = np.sign(phi[0]) * (np.abs(phi[0]) + 0.2)
    w0 = 2 * np.pi * hz[:, None]
    frf = ((phi * phi[0]) @ (-(OMEGA**2) / (w0**2 - OMEGA**2 + 2j * zeta[:, None] * w0 * OMEGA)))[:, None]
    noise = rng.normal(size=(*frf.shape, 2)) @ [1, 1j] / np.sqrt(2)
    return hz, frf + 10 ** rng.uniform(-3.5, -1.5, (2, 1, 1)) * np.abs(frf).mean() * noise


def found(frf: NDArray[np.complex128], outputs: list[int], quantity: str = "inertance") -> ModalModel | None:
    try:
        return ml.identify(ml.frf(LINES, frf, [1], outputs, quantity), progress=False).modal  # type: ignore[arg-type]
    except ModallabError:
        return None


def lost(hz: NDArray[np.float64], frf: NDArray[np.complex128]) -> tuple[int, int]:
    """Modes that one sensor finds, and those of them that both lose."""
    models = [found(frf[rows], outputs) for rows, outputs in ((slice(1), [1]), (slice(1, 2), [2]), (slice(2), [1, 2]))]
    there = [[m is not None and bool(np.any(np.abs(m.frequency_hz / f - 1) < SAME)) for f in hz] for m in models]
    either = [a or b for a, b in zip(*there[:2], strict=True)]
    return sum(either), sum(e and not both for e, both in zip(either, there[2], strict=True))


def apart(frf: NDArray[np.complex128]) -> float:
    """Largest difference of frequencies and damping ratios between quantities, in sigma; infinite if modes differ."""
    forms = {"inertance": frf, "mobility": frf / (1j * OMEGA), "receptance": frf / -(OMEGA**2)}
    first, *others = (found(values, [1, 2], quantity) for quantity, values in forms.items())
    if first is None or any(o is None or o.n_modes != first.n_modes for o in others):
        return float("inf")
    pairs = [(o.frequency_hz - first.frequency_hz) / first.frequency_sigma_hz for o in others if o is not None]
    pairs += [(o.damping_ratio - first.damping_ratio) / first.damping_sigma for o in others if o is not None]
    return float(np.abs(pairs).max())


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--structures", type=int, default=20)
    parser.add_argument("--first", type=int, default=300)
    asked = parser.parse_args()
    made = [structure(seed) for seed in range(asked.first, asked.first + asked.structures)]
    counts = np.sum([lost(*one) for one in made], axis=0)
    print(f"modes that one sensor finds: {counts[0]}; lost by both: {counts[1]}")
    print(f"three quantities apart by at most {max(apart(frf) for _, frf in made):.2g} sigma")


if __name__ == "__main__":
    main()
