"""Recordings for the tests of this folder: a decaying beam as any bench would deliver it."""

from pathlib import Path
from typing import Any

import numpy as np
import pyuff
from numpy.typing import NDArray

from modallab.schema.block import Block, Campaign
from modallab.schema.rig import Rig

DATA = Path(__file__).parent.parent / "data"
RATE_HZ = 2000.0


def hit(channels: int, n: int = 256, seed: int = 1) -> NDArray[np.float64]:
    """Force in N and accelerations in m/s^2, (channels, n): a blow and one decaying mode with a little noise."""
    t = np.arange(n) / RATE_HZ
    since = np.clip(t - 0.01, 0, None)
    force = 60 * np.exp(-(((t - 0.01) / 0.001) ** 2))
    mode = np.exp(-20 * since) * np.sin(2 * np.pi * 87.8 * since)
    rows = [force, *((k + 1) * mode for k in range(channels - 1))]
    return np.stack(rows) + np.random.default_rng(seed).normal(0, 0.02, (channels, n))


def times(n: int = 256) -> NDArray[np.float64]:
    return np.arange(n) / RATE_HZ


def block(rig: Rig, samples: NDArray[Any], **facts: Any) -> Block:
    n = len(rig.channels)
    content: dict[str, Any] = {
        "name": "hit_1",
        "test": "impact",
        "order": 0,
        "rate_hz": RATE_HZ,
        "samples": samples,
        "scale": np.full(n, 10 / 32768),
        "units": ("V",) * n,
        "channels": tuple(c.name for c in rig.channels),
    }
    return Block(**(content | facts))


def counts(rig: Rig, seed: int = 1) -> NDArray[np.int16]:
    return np.round(100 * hit(len(rig.channels), seed=seed)).astype(np.int16)


def campaign(rig: Rig, *blocks: Block, **facts: Any) -> Campaign:
    return Campaign(rig, blocks or (block(rig, counts(rig)),), **facts)


def uff_set(values: NDArray[Any], axis: NDArray[np.float64], kind: int, **fields: Any) -> dict[str, Any]:
    """A set of type 58 as pyuff writes it."""
    frf = kind in (4, 6)
    return {
        "type": 58,
        "func_type": kind,
        "rsp_node": 0,
        "rsp_dir": 0,
        "ref_node": 0,
        "ref_dir": 0,
        "data": values,
        "x": axis,
        "abscissa_spacing": 1,
        "abscissa_spec_data_type": 18 if frf else 17,
        "ordinate_spec_data_type": 12,
        "ordinate_axis_units_lab": "m/s^2",
        "orddenom_spec_data_type": 13 if frf else 0,
        "orddenom_axis_units_lab": "N" if frf else "NONE",
        "z_axis_axis_lab": "NONE",
    } | fields


def write_uff(path: Path, *sets: dict[str, Any], binary: bool = False) -> Path:
    for number, content in enumerate(sets):
        pyuff.UFF(str(path)).write_sets(dict(content, binary=int(binary)), "add" if number else "overwrite")
    return path


def write_hit_uff(path: Path, samples: NDArray[np.float64], *, binary: bool = False, force_node: int = 0) -> Path:
    """Force and accelerations at nodes 1, 2, ... in +z."""
    force = uff_set(
        samples[0], times(samples.shape[1]), 1, ordinate_spec_data_type=13, ordinate_axis_units_lab="N",
        rsp_node=force_node, rsp_dir=3 if force_node else 0,
    )  # fmt: skip
    rest = [uff_set(row, times(len(row)), 1, rsp_node=k, rsp_dir=3) for k, row in enumerate(samples[1:], start=1)]
    return write_uff(path, force, *rest, binary=binary)


def receptances(n_lines: int = 64) -> NDArray[np.complex128]:
    """(3, lines) FRFs of one mode at 20 Hz seen at three points."""
    omega = 2 * np.pi * np.arange(1, n_lines + 1)
    one = 1 / ((2 * np.pi * 20) ** 2 - omega**2 + 2j * 0.01 * 2 * np.pi * 20 * omega)
    return np.stack([one, 2 * one, -3 * one])
