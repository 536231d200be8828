"""Blocks of a closed-form structure under every kind of drive, labelled as one pleases."""

from dataclasses import replace

import modal_bench as bench
import numpy as np
from numpy.typing import NDArray
from scipy import signal

from modallab.core.block import Block, Campaign
from modallab.core.units import Test

RATE, N, BLOCKS, POINT = 1000.0, 1024, 4, 5


def force(kind: Test, rng: np.random.Generator) -> NDArray[np.float64]:
    """(samples,) N of one run-in block and `BLOCKS` more."""
    total = (BLOCKS + 1) * N
    t = np.arange(total) / RATE
    if kind == "impact":
        width, at = rng.uniform(0.003, 0.012), rng.uniform(0.02, 0.1)
        hits = [bench.pulse(total, RATE, k * N / RATE + at, width, rng.uniform(20, 80)) for k in range(BLOCKS + 1)]
        return np.sum(hits, axis=0)
    if kind == "sine":
        return rng.uniform(1, 10) * np.sin(2 * np.pi * rng.uniform(4, 200) * t + rng.uniform(0, 6))
    low = rng.uniform(3, 10)
    edges = [low, low + rng.uniform(40, 350)]
    if kind == "chirp":
        once = signal.chirp(t[:N], edges[0], N / RATE, edges[1], method=rng.choice(["linear", "logarithmic"]))
        return np.tile(rng.uniform(1, 10) * once, BLOCKS + 1)
    noise = signal.sosfilt(signal.butter(4, edges, "bandpass", fs=RATE, output="sos"), rng.normal(size=total))
    if kind == "burst-random":
        share = rng.uniform(0.2, 0.75)
        noise = noise * (np.arange(total) % N < share * N)
    if kind == "pseudo-random":
        spectrum = np.fft.rfft(noise[:N])
        noise = np.tile(np.fft.irfft(spectrum, N), BLOCKS + 1)
    return rng.uniform(1, 10) * noise / noise.std()


def campaign(kind: Test, label: Test, seed: int) -> Campaign:
    """Four blocks driven by `kind` and labelled `label`, with noise on every channel."""
    rng = np.random.default_rng(seed)
    system, rig = bench.modes(rng), bench.rig(5)
    f = force(kind, rng)
    samples = np.vstack([f, bench.respond(system, f, POINT, RATE)])
    samples += rng.uniform(1e-4, 1e-3) * samples.std(axis=1, keepdims=True) * rng.normal(size=samples.shape)
    return Campaign(rig=rig, blocks=tuple(_block(samples, k, label, rng) for k in range(BLOCKS)), source="made")


def _block(samples: NDArray[np.float64], k: int, label: Test, rng: np.random.Generator) -> Block:
    here = samples[:, (k + 1) * N : (k + 2) * N]
    strongest = float(np.argmax(np.abs(np.fft.rfft(here[0]))[1:]) + 1) * RATE / N
    name, asked = f"{label}_{k}", strongest if label == "sine" else None
    return replace(bench.block(name, label, k, RATE, here, POINT), frequency_hz=asked, first_sample=k * N)
