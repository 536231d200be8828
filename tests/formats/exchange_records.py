"""Recordings for the tests of this folder: a decaying beam as any bench would deliver it."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign
from modallab.core.rig import Rig

DATA = Path(__file__).parent.parent / "data"
RATE_HZ = 2000.0


def hit(channels: int, n: int = 256, seed: int = 1) -> NDArray[np.float64]:
    """Force in N and accelerations in m/s^2, (channels, n): a hit and one decaying mode with a little noise."""
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
    """A set of type 58, by the field names of pyuff."""
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
    } | fields


def write_uff(path: Path, *sets: dict[str, Any], binary: bool = False) -> Path:
    """Sets of type 58 by the letter of the format, in double precision (pyuff writes NaN as 0)."""
    path.write_bytes(
        b"".join(_set_58(content, binary) if content["type"] == 58 else _set_164(content) for content in sets)
    )
    return path


def _set_164(s: dict[str, Any]) -> bytes:
    """Units by the field names of pyuff; of millimetre and millinewton unless it says others."""
    factors = "".join(f"{v:25.17E}".replace("E", "D") for v in (s.get("length", 1e3), s.get("force", 1e3), 1.0))
    return (
        f"    -1\n   164\n{s.get('units_code', 5):10d}{'units':20s}{1:10d}\n{factors}\n{0.0:25.17E}\n    -1\n".encode()
    )


def _set_58(s: dict[str, Any], binary: bool) -> bytes:
    values, x = np.asarray(s["data"]), np.asarray(s["x"], dtype=np.float64)
    even, is_complex = bool(s["abscissa_spacing"]), np.iscomplexobj(values)
    parts = [values.real, values.imag] if is_complex else [values]
    numbers = np.stack(parts if even else [x, *parts], axis=1).ravel().astype("<f8")
    kind = f"b{1:6d}{2:6d}{11:12d}{numbers.nbytes:12d}{0:6d}{0:6d}{0:12d}{0:12d}" if binary else " " * 74
    start, step = (x[0], x[1] - x[0]) if even else (0.0, 0.0)
    name = s.get("rsp_ent_name", "NONE")
    axes = [
        (s["abscissa_spec_data_type"], "NONE"),
        (s["ordinate_spec_data_type"], s["ordinate_axis_units_lab"]),
        (s["orddenom_spec_data_type"], s["orddenom_axis_units_lab"]),
        (0, "NONE"),
    ]
    head = [
        "    -1",
        f"    58{kind}",
        *["NONE"] * 5,
        f"{s['func_type']:5d}{0:10d}{0:5d}{0:10d} {name:10s}{s['rsp_node']:10d}{s['rsp_dir']:4d} {'NONE':10s}"
        f"{s['ref_node']:10d}{s['ref_dir']:4d}",
        f"{6 if is_complex else 4:10d}{len(values):10d}{even:10d}{start:13.5e}{step:13.5e}{0:13.5e}",
        *[f"{specific:10d}{0:5d}{0:5d}{0:5d} {'NONE':20s} {unit:20s}" for specific, unit in axes],
        "",
    ]
    return (
        "\n".join(head).encode() + (numbers.tobytes() if binary else _text(numbers, even, len(parts))) + b"\n    -1\n"
    )


def _text(numbers: NDArray[np.float64], even: bool, parts: int) -> bytes:
    if even:
        rows = [numbers[i : i + 4] for i in range(0, len(numbers), 4)]
        return "\n".join("".join(f"{v:20.11e}" for v in row) for row in rows).encode()
    width = 1 + parts
    points = ["".join([f"{row[0]:13.5e}", *(f"{v:20.11e}" for v in row[1:])]) for row in numbers.reshape(-1, width)]
    per_line = 1 if parts == 2 else 2
    return "\n".join("".join(points[i : i + per_line]) for i in range(0, len(points), per_line)).encode()


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
