"""Many looks at once decide as they do one by one."""

import re
from collections.abc import Callable

import numpy as np
import pytest

from modallab.acquisition.monitor.plausibility import Plausibility
from modallab.acquisition.monitor.rest_noise import RestNoise
from modallab.bench.protocol import Burst, SampleChunk
from modallab.core.errors import SafetyError

RATE_HZ, NOISE = 2000.0, 10.0
BURST = Burst(70.0, 0.5, 0.5, 2.0)
SIZES = np.array([2000.0, 9000.0, -6000.0, 900.0, 27.0])
AT = 3037
"""Sample from which on a channel fails."""

Fault = Callable[[np.ndarray, np.ndarray], None]


def frozen(counts: np.ndarray, _: np.ndarray) -> None:
    counts[3, AT:] = counts[3, AT]


def noise_alone(counts: np.ndarray, noise: np.ndarray) -> None:
    counts[2, AT:] = noise[2, AT:]


def no_force(counts: np.ndarray, noise: np.ndarray) -> None:
    counts[0, AT:] = noise[0, AT:]


def exchanged(counts: np.ndarray, _: np.ndarray) -> None:
    counts[[1, 3], AT:] = counts[[3, 1], AT:]


def clipped(counts: np.ndarray, _: np.ndarray) -> None:
    counts[1, AT:] = np.clip(counts[1, AT:], -4000, 4000)


def weak_lost(counts: np.ndarray, noise: np.ndarray) -> None:
    counts[4, AT:] = noise[4, AT:]


def sound(_: np.ndarray, __: np.ndarray) -> None:
    pass


def verdict(fault: Fault, drawn: int, at_once: int) -> str:
    """What a burst with a fault ends with, read so many samples at once."""
    rng = np.random.default_rng(drawn)
    times = np.arange(round(BURST.duration_s * RATE_HZ)) / RATE_HZ
    phases = np.exp(2j * np.pi * (BURST.frequency_hz * times + 0.02 * np.arange(len(SIZES))[:, None]))
    noise = np.round(rng.normal(0, NOISE, phases.shape)).astype(np.int16)
    counts = np.round(SIZES[:, None] * BURST.envelope(times) * phases.imag).astype(np.int16) + noise
    fault(counts, noise)
    rest = np.round(rng.normal(0, NOISE, (len(SIZES), 2000))).astype(np.int16)
    rows = range(len(SIZES))
    watch = Plausibility(tuple("fabcd"), np.ones(len(SIZES)), np.ones(len(SIZES)), 0, rows, RATE_HZ)
    watch.begin(BURST, 0, rest, RestNoise.of(rest, counts=True), 0)
    try:
        for first in range(0, len(times), at_once):
            watch(SampleChunk(first, counts[:, first : first + at_once], np.zeros(len(SIZES), dtype=np.bool_)))
    except SafetyError as error:
        # How often a value had come when it was seen is a matter of how many were read.
        return re.sub(r"for \d+ samples", "", error.what)
    return ""


@pytest.mark.parametrize("fault", [sound, frozen, noise_alone, no_force, exchanged, clipped, weak_lost])
def test_many_looks_at_once_end_as_one_by_one(fault: Fault) -> None:
    ended = verdict(fault, 5, at_once=1000)
    assert ended == verdict(fault, 5, at_once=20)
    assert bool(ended) == (fault is not sound)
