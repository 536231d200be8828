"""Responses alone with periodic excitation, in several set-ups: the truth is known, and drawn anew for each campaign.

    python benchmarks/identification/harmonics.py --campaigns 100 [--csv FILE]

A campaign has 3 to 5 modes between 2 and 40 Hz, 1 to 15 set-ups of two sensors that stay and two that rove, and 0 to 6
harmonics of a machine, half of whose speeds wander. For each it prints how many modes the joined model has, how many
are spurious, and how many harmonics stand in the model as modes or are named in no note.
"""

import argparse
import csv
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import modallab as ml
from modallab.core.errors import ModallabError

RATE_HZ, SECONDS = 100.0, 400.0
SAME = 0.02
COLUMNS = ("campaign", "modes", "set-ups", "harmonics", "wander", "found", "spurious", "harmonics as modes", "unnamed")


def frequencies(rng: np.random.Generator) -> NDArray[np.float64]:
    """Of modes at least a tenth apart."""
    while True:
        drawn = np.sort(np.exp(rng.uniform(np.log(2), np.log(38), rng.integers(3, 6))))
        if np.all(drawn[1:] / drawn[:-1] > 1.1):
            return drawn


def orders(rng: np.random.Generator, modes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Harmonics that stand off every mode by three of its half-widths of 1 %."""
    speed, count = rng.uniform(4, 9), int(rng.integers(0, 7))
    drawn = speed * np.sort(rng.choice(np.arange(1, 8), count, replace=False))
    return np.array([h for h in drawn if h < 42 and np.all(np.abs(h / modes - 1) > 0.03)])


def campaign(rng: np.random.Generator) -> tuple[list[ml.Recording], NDArray[np.float64], NDArray[np.float64], float]:
    """Set-ups, the modes, the harmonics, and by how much the speed wanders."""
    modes = frequencies(rng)
    lines, wander = orders(rng, modes), float(rng.choice([0.0, 0.03]))
    zeta, count = rng.uniform(0.005, 0.02, modes.size), int(rng.integers(1, 16))
    points = 2 + 2 * count
    shapes, forced = rng.normal(size=(points, modes.size)), rng.normal(size=(points, lines.size))
    shapes[:2] = np.sign(shapes[:2]) * (np.abs(shapes[:2]) + 0.3)
    level = rng.uniform(0.3, 2.0)
    made = []
    for k in range(count):
        stand = [0, 1, 2 + 2 * k, 3 + 2 * k]
        made.append(ml.responses(record(rng, modes, zeta, shapes[stand], lines, level * forced[stand], wander),
                                 RATE_HZ, points=[p + 1 for p in stand]))  # fmt: skip
    return made, modes, lines, wander


def record(rng, modes, zeta, shapes, lines, forced, wander) -> NDArray[np.float64]:
    n = int(RATE_HZ * SECONDS)
    omega = 2 * np.pi * np.fft.rfftfreq(n, 1 / RATE_HZ)
    y = np.zeros((len(shapes), n))
    for f, z, shape in zip(modes, zeta, shapes.T, strict=True):
        w = 2 * np.pi * f
        frf = omega**2 / (w**2 - omega**2 + 2j * z * w * omega)
        one = np.fft.irfft(np.fft.rfft(rng.normal(size=n)) * frf, n)
        y += np.outer(shape, one / one.std())
    t, phase = np.arange(n) / RATE_HZ, wander * np.cumsum(rng.normal(size=n)) / np.sqrt(RATE_HZ)
    for h, shape in zip(lines, forced.T, strict=True):
        y += np.outer(shape, np.cos(2 * np.pi * h * t + h / max(lines.min(), 1.0) * phase + rng.uniform(0, 6)))
    return y + 0.02 * rng.normal(size=y.shape)


def judged(number: int) -> dict[str, object]:
    """One row of the table."""
    rng = np.random.default_rng(number)
    made, modes, lines, wander = campaign(rng)
    facts = {"campaign": number, "modes": modes.size, "set-ups": len(made), "harmonics": lines.size, "wander": wander}
    try:
        model = ml.identify(made if len(made) > 1 else made[0], band=(1.0, 45.0), progress=False).modal_model
        found, notes = np.asarray(model.frequency_hz), " ".join(model.notes)
    except ModallabError as error:
        found, notes = np.zeros(0), str(error)
    named = np.array([float(v) for said in re.findall(r"harmonics at ([\d., ]+) Hz", notes) for v in said.split(",")])
    near = np.abs(found[:, None] / modes - 1) < SAME
    as_modes = [f for f, own in zip(found, near, strict=True) if not own.any() and np.any(np.abs(f / lines - 1) < SAME)]
    return facts | {
        "found": int(near.any(axis=0).sum()),
        "spurious": int((~near.any(axis=1)).sum()) - len(as_modes),
        "harmonics as modes": len(as_modes),
        "unnamed": int(sum(not np.any(np.abs(named / h - 1) < 0.01) for h in lines)),
    }


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--csv", type=Path)
    a = parser.parse_args()
    rows = []
    for number in range(a.first, a.first + a.campaigns):
        rows.append(judged(number))
        print(*rows[-1].values(), flush=True)
    total = {name: sum(int(str(row[name])) for row in rows) for name in COLUMNS if name not in ("campaign", "wander")}
    print("all", total)
    if a.csv:
        with a.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
