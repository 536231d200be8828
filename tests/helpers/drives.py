"""Blocks of a closed-form structure under every kind of drive, labelled as one pleases."""

from dataclasses import replace
from typing import Literal

import modal_bench as bench
import numpy as np
from numpy.typing import NDArray
from scipy import signal

from modallab.core.block import Block, Campaign
from modallab.core.units import Test

RATE, N, BLOCKS, POINT = 1000.0, 1024, 4, 5
RING = 200
"""Samples after which a structure that rings down without a force was let go."""

Real = NDArray[np.float64]
Kind = Test | Literal["stepped-sine", "multisine", "schroeder", "ring-down", "release", "idle"]
RIGHT: dict[Kind, tuple[Test, ...]] = {
    "impact": ("impact",),
    "sine": ("sine",),
    "random": ("random",),
    "burst-random": ("burst-random",),
    "pseudo-random": ("pseudo-random",),
    "chirp": ("chirp", "pseudo-random"),
    "stepped-sine": ("pseudo-random", "chirp"),
    "multisine": ("pseudo-random",),
    "schroeder": ("pseudo-random", "chirp"),
    "ring-down": (),
    "release": (),
    "idle": (),
}
"""What each kind may be labelled: a sweep that every block repeats is periodic, and so is a tone that is stepped within
a block, which is a sweep as well; a multisine of Schroeder's phases is a sweep."""


def force(kind: Kind, rng: np.random.Generator) -> Real:
    """(samples,) N of one run-in block and `BLOCKS` more."""
    total = (BLOCKS + 1) * N
    t = np.arange(total) / RATE
    if kind in ("ring-down", "idle"):
        return np.zeros(total)
    if kind == "impact":
        width, at = rng.uniform(0.003, 0.012), rng.uniform(0.02, 0.1)
        hits = [bench.pulse(total, RATE, k * N / RATE + at, width, rng.uniform(20, 80)) for k in range(BLOCKS + 1)]
        return np.sum(hits, axis=0)
    if kind == "sine":
        return rng.uniform(1, 10) * np.sin(2 * np.pi * rng.uniform(4, 200) * t + rng.uniform(0, 6))
    if kind == "release":
        held = np.arange(total) % N < rng.uniform(0.03, 0.3) * N
        return np.repeat(rng.uniform(5, 50, BLOCKS + 1), N) * held
    low = rng.uniform(3, 10)
    edges = [low, low + rng.uniform(40, 350)]
    once = _periodic(kind, rng, edges, t[:N])
    if once is not None:
        return np.tile(rng.uniform(1, 10) * once / once.std(), BLOCKS + 1)
    noise = signal.sosfilt(signal.butter(4, edges, "bandpass", fs=RATE, output="sos"), rng.normal(size=total))
    if kind == "burst-random":
        share = rng.uniform(0.2, 0.75)
        noise = noise * (np.arange(total) % N < share * N)
    if kind == "pseudo-random":
        noise = np.tile(np.fft.irfft(np.fft.rfft(noise[:N]), N), BLOCKS + 1)
    return rng.uniform(1, 10) * noise / noise.std()


def _periodic(kind: Kind, rng: np.random.Generator, edges: list[float], t: Real) -> Real | None:
    """One period of what is the same in every block; None for what is not."""
    if kind == "chirp":
        return signal.chirp(t, edges[0], N / RATE, edges[1], method=rng.choice(["linear", "logarithmic"]))
    if kind == "stepped-sine":
        steps = int(rng.integers(4, 12))
        tones = np.repeat(np.geomspace(*edges, steps), N // steps + 1)[:N]
        return np.sin(2 * np.pi * np.cumsum(tones) / RATE)
    if kind in ("multisine", "schroeder"):
        lines = np.arange(int(edges[0]) + 1, int(edges[1]), 1 if kind == "schroeder" else int(rng.integers(1, 3)))
        k = np.arange(lines.size)
        phases = -np.pi * k * (k - 1) / lines.size if kind == "schroeder" else rng.uniform(0, 2 * np.pi, lines.size)
        return np.sum(np.cos(2 * np.pi * RATE / N * np.outer(lines, t) + phases[:, None]), axis=0)
    return None


def campaign(kind: Kind, label: Test, seed: int) -> Campaign:
    """Four blocks driven by `kind` and labelled `label`, with noise on every channel."""
    rng = np.random.default_rng(seed)
    system, rig = bench.modes(rng), bench.rig(5)
    f = force(kind, rng)
    samples = np.vstack([f, _responses(kind, system, f)])
    spread = np.where(samples.std(axis=1) > 0, samples.std(axis=1), 1.0)[:, None]
    samples += rng.uniform(1e-4, 1e-3) * spread * rng.normal(size=samples.shape)
    return Campaign(rig=rig, blocks=tuple(_block(samples, k, label, rng) for k in range(BLOCKS)), source="made")


def _responses(kind: Kind, system: bench.Modes, f: Real) -> Real:
    if kind == "release":
        # Held until it rests, and let go: as if the force that is taken away were put on, block by block.
        parts = [bench.respond(system, part - part[0], POINT, RATE) for part in np.split(f, BLOCKS + 1)]
        return np.concatenate(parts, axis=1)
    hits = np.tile(bench.pulse(N, RATE, RING / RATE, 0.01, 30.0), BLOCKS + 1)
    return bench.respond(system, hits if kind == "ring-down" else f, POINT, RATE)


def _block(samples: Real, k: int, label: Test, rng: np.random.Generator) -> Block:
    here = samples[:, (k + 1) * N : (k + 2) * N]
    strongest = float(np.argmax(np.abs(np.fft.rfft(here[0]))[1:]) + 1) * RATE / N
    name, asked = f"{label}_{k}", strongest if label == "sine" else None
    return replace(bench.block(name, label, k, RATE, here, POINT), frequency_hz=asked, first_sample=k * N)
