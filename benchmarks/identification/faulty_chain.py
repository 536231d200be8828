"""Faults of the chain put into records of a known structure: is each named, and are the modes those of the structure?

    python benchmarks/identification/faulty_chain.py --faults 30 --seed 1 [--csv FILE]

Five hits on a structure of three drawn modes, a force and four accelerations at 2048 Hz with 16 bits. Each draw spoils
one channel of one record, or of all: by what happens to cables, ranges, clocks and hands. Named: what is said before or
with the model holds the channel and the record, and the time of a fault that begins within it. Unsaid: nothing names
the channel, and a mode is lost, beside the truth by more than five sigmas and 0.2 % (5 % in damping), or of the fault.
"""

import argparse
import csv
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from faulty_samples import said_of
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign
from modallab.core.errors import ModallabError
from modallab.core.rig import Channel, Point, Rig
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.response_only import identify_chosen

Real = NDArray[np.float64]
RATE, N, HITS = 2048.0, 4096, 5
SAME, NEAR = 0.005, 0.02
"""A mode is the same within SAME; a time is named within NEAR of the record."""
HEAD = ("number", "kind", "channel", "records", "record", "time_s", "named", "lost", "off", "others", "unsaid", "said")
NAMES = ("force", "a1", "a2", "a3", "a4")
RIG = Rig(
    name="a structure",
    model="unknown",
    points=tuple(Point(id=k, x_m=0.1 * k) for k in range(1, 5)),
    channels=(
        Channel(index=0, name="force", quantity="force", unit="N", point=1),
        *(Channel(index=k, name=f"a{k}", quantity="acceleration", unit="m/s^2", point=k) for k in range(1, 5)),
    ),
)


@dataclass(frozen=True)
class Truth:
    """Frequencies in Hz, damping ratios and shapes (modes, points)."""

    frequency: Real
    damping: Real
    shape: Real

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> "Truth":
        f = rng.uniform(30, 60) * np.cumprod([1, *rng.uniform(1.6, 2.4, 2)])
        return cls(f, rng.uniform(0.005, 0.02, 3), rng.uniform(0.3, 1.0, (3, 4)) * rng.choice([-1, 1], (3, 4)))

    def record(self, force: Real) -> Real:
        """(5, n): the force and what it makes."""
        s = 2j * np.pi * np.fft.rfftfreq(8 * N, 1 / RATE)
        w = 2 * np.pi * self.frequency[:, None]
        modal = s**2 / (s**2 + 2 * self.damping[:, None] * w * s + w**2)
        h = np.einsum("mo,m,mf->of", self.shape, self.shape[:, 0], modal)
        return np.vstack([force, np.fft.irfft(h * np.fft.rfft(force, 8 * N))[:, :N]])


def pulse(at: float, size: float, width: float = 0.004) -> Real:
    t = np.arange(N) / RATE - at
    return size * np.where((t > 0) & (t < width), np.sin(np.pi * np.clip(t / width, 0, 1)) ** 2, 0.0)


def lost(row: Real, first: int, rng: np.random.Generator) -> Real:
    """Some samples are missing, those behind move up."""
    count = int(rng.integers(3, 60))
    return np.r_[row[:first], row[first + count :], np.zeros(count) + row[-1]]


def delayed(row: Real, first: int, rng: np.random.Generator) -> Real:
    """The whole channel is late."""
    return np.roll(row, int(rng.integers(2, 12)))


def hum(row: Real, first: int, rng: np.random.Generator) -> Real:
    t = np.arange(N) / RATE
    return row + rng.uniform(0.03, 0.3) * np.abs(row).max() * np.sin(2 * np.pi * 50 * t + rng.uniform(0, 6))


def spikes(row: Real, first: int, rng: np.random.Generator) -> Real:
    """A loose plug: single samples far off, some of them."""
    out, where = row.copy(), first + rng.integers(0, 300, int(rng.integers(1, 12)))
    where[0] = first
    out[where] += rng.choice([-1, 1], len(where)) * rng.uniform(1, 5, len(where)) * np.abs(row).max()
    return out


def stepped(row: Real, first: int, rng: np.random.Generator) -> Real:
    """The zero jumps, and stays."""
    return row + rng.choice([-1, 1]) * rng.uniform(0.3, 2) * np.abs(row).max() * (np.arange(N) >= first)


def gain(row: Real, first: int, rng: np.random.Generator) -> Real:
    """Another range than the one that the file names."""
    return row * rng.choice([0.1, 10.0, 3.16, 0.5])


def inverted(row: Real, first: int, rng: np.random.Generator) -> Real:
    return -row


def burst(row: Real, first: int, rng: np.random.Generator) -> Real:
    """Broad noise for a while, as of a cable that moves."""
    out, length = row.copy(), int(rng.uniform(0.02, 0.2) * N)
    part = out[first : first + length]
    part += rng.uniform(0.2, 1) * np.abs(row).max() * rng.normal(size=len(part))
    return out


def unplugged(row: Real, first: int, rng: np.random.Generator) -> Real:
    """From some time on only the noise of the input."""
    out = row.copy()
    out[first:] = np.abs(row).max() * 1e-4 * rng.normal(size=N - first)
    return out


def clipped_hit(row: Real, first: int, rng: np.random.Generator) -> Real:
    return np.minimum(row, rng.uniform(0.5, 0.9) * row.max())


KINDS: dict[str, Callable[[Real, int, np.random.Generator], Real]] = {
    one.__name__: one for one in (lost, delayed, hum, spikes, stepped, gain, inverted, burst, unplugged, clipped_hit)
}
WHOLE = ("delayed", "hum", "gain", "inverted", "swapped", "clipped_hit")
OF_ONE = ("delayed", "inverted", "swapped", "gain")
"""What shows only beside records without it."""


def spoilt(number: int, seed: int) -> tuple[Truth, Campaign, str, tuple[str, ...], list[int], float]:
    """The truth, the records, the kind of fault, the channels, the records that have it, and when it begins in s."""
    rng = np.random.default_rng([seed, number])
    truth = Truth.drawn(rng)
    records = [truth.record(pulse(0.05, rng.uniform(40, 120))) for _ in range(HITS)]
    kind = str(rng.choice([*KINDS, "swapped", "double_hit"]))
    every = rng.random() < 0.3 and kind not in OF_ONE
    which = list(range(HITS)) if every else [int(rng.integers(HITS))]
    row, first = int(rng.integers(5)) if kind != "clipped_hit" else 0, int(rng.uniform(0.1, 0.6) * N)
    channels, time = (NAMES[row],), first / RATE
    pair = rng.choice(np.arange(1, 5), 2, replace=False)
    again = 0.05 + rng.uniform(0.05, 0.5)
    for k in which:
        if kind == "double_hit":
            time, channels = again, ("force",)
            records[k] = truth.record(records[k][0] + pulse(time, rng.uniform(5, 60)))
        elif kind == "swapped":
            channels = (NAMES[pair[0]], NAMES[pair[1]])
            records[k][pair] = records[k][pair[::-1]]
        else:
            records[k][row] = KINDS[kind](records[k][row], first, rng)
    scale = np.array([1.5 * max(np.abs(r[c]).max() for r in records) / 32768 for c in range(5)])
    counts = [np.round(r / scale[:, None] + rng.normal(size=(5, N))).astype(np.int16) for r in records]
    facts = {"test": "impact", "rate_hz": RATE, "scale": scale, "channels": NAMES, "drive_point": 1}
    units = ("N", *["m/s^2"] * 4)
    blocks = tuple(Block(name=f"hit_{k}", order=k, samples=c, units=units, **facts) for k, c in enumerate(counts))
    return truth, Campaign(RIG, blocks), kind, channels, which, 0.0 if kind in WHOLE else time


def judged(campaign: Campaign, truth: Truth) -> tuple[str, int, int, int]:
    """What is said with the model, and how many modes are lost, off, and of nothing."""
    try:
        result = identify_chosen(campaign, IdentificationOptions()).identified[0]
    except ModallabError as error:
        return str(error), 0, 0, 0
    model, confidence = result.model, result.assessment.confidence
    f, z = np.array(model.frequency_hz), np.array(model.damping_ratio)
    gone, off, used = 0, 0, set[int]()
    for right, zeta in zip(truth.frequency, truth.damping, strict=True):
        k = int(np.abs(f - right).argmin())
        if abs(f[k] / right - 1) > SAME:
            gone += 1
            continue
        used.add(k)
        far = abs(f[k] - right) > max(5 * model.frequency_sigma_hz[k], 2e-3 * right)
        off += int(far or abs(z[k] - zeta) > max(5 * model.damping_sigma[k], 0.05 * zeta))
    others = sum(k not in used and c > 0.5 for k, c in enumerate(confidence))
    return " ".join(model.notes), gone, off, others


def names_it(said: str, channels: tuple[str, ...], records: list[int], at: float) -> bool:
    """Whether the channel, one of its records, and the time are said."""
    channel = any(re.search(rf"\b{c}\b", said) for c in channels)
    record = len(records) > 1 or f"hit_{records[0]}" in said
    seconds = [float(v) for v in re.findall(r"(?:from|at) ([\d.e+-]+) s", said)]
    seconds += [float(v) / RATE for v in re.findall(r"sample (\d+)", said)]
    return channel and record and (not at or any(abs(s - at) < NEAR * N / RATE for s in seconds))


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--faults", type=int, default=30)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--csv", type=Path)
    a = parser.parse_args()
    rows = []
    for number in range(a.faults):
        truth, campaign, kind, channels, records, at = spoilt(number, a.seed)
        words, *counts = judged(campaign, truth)
        said = f"{said_of(campaign)} {words}"
        part = any(re.search(rf"\b{c}\b", said) for c in channels)
        row = (number, kind, "+".join(channels), len(records), f"hit_{records[0]}", f"{at:.4g}")
        rows.append((*row, int(names_it(said, channels, records, at)), *counts, int(not part and any(counts)), said))
        print(*rows[-1][:-1], "" if rows[-1][6] else said[:400], flush=True)
    print(f"named {sum(r[6] for r in rows)} of {len(rows)}; without notice {sum(r[10] for r in rows)}; modes lost "
          f"{sum(r[7] for r in rows)}, off {sum(r[8] for r in rows)}, others {sum(r[9] for r in rows)}")  # fmt: skip
    if a.csv:
        with a.csv.open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([HEAD, *rows])


if __name__ == "__main__":
    main()
