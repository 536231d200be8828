"""A mass, spring or damper is predicted from the measured model of a simulated bench, then put on it and measured.

    python benchmarks/modified.py 40 benchmarks/results/modified.csv

Each bench is as built in an ordinary lab, and no other one. A row is a mode below half the band.
"""

import sys
from pathlib import Path
from typing import Protocol

import numpy as np

import modallab as ml
from by_seed import measure
from modallab.core.model import ModalModel
from modallab.core.plan import ImpactPlan
from modallab.core.rig import Tolerance
from modallab.modification.attachments import Element
from modallab.modification.known import KnownStructure
from modallab.modification.modified import ModifiedModes

PLAN = ImpactPlan(points=(10, 6, 3), hits=5)
POINTS = 10
FIRST_SEED = 7101
COLUMNS = (
    "seed", "kind", "size", "point", "mode", "before_hz", "predicted_hz", "sigma_hz", "measured_hz",
    "measured_sigma_hz", "predicted_zeta", "zeta_sigma", "measured_zeta",
)  # fmt: skip
EFFECTS = {"mass": ("added_mass", "mass"), "spring": ("ground_spring", "k"), "damper": ("local_damper", "c")}


def drawn(seed: int) -> tuple[str, float, int]:
    """Kind, size and point of a bench."""
    rng = np.random.default_rng(seed)
    kind = ("mass", "spring", "damper")[seed % 3]
    low, high = {"mass": (0.02, 0.3), "spring": (5e2, 2e4), "damper": (0.5, 5.0)}[kind]
    return kind, float(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.4g}"), int(rng.integers(3, POINTS + 1))


def effect_of(kind: str, size: float, point: int) -> str:
    """As the simulated bench takes it."""
    name, number = EFFECTS[kind]
    return f"{name},{number}={size},x={point / POINTS}"


def rows_of(seed: int) -> list[list[object]]:
    """Predicted and measured modes of one bench."""
    kind, size, point = drawn(seed)
    effects: tuple[str | tuple[()], ...] = ((), effect_of(kind, size, point))
    tests = [ml.simulate("link", e, seed=seed, tolerances="usual", plan=PLAN, progress=False) for e in effects]
    bare, changed = (ml.identify(test, "impact", progress=False) for test in tests)
    rig = bare.campaign.rig.model_copy(update={"tolerance": Tolerance.usual()})
    known = KnownStructure(bare.modal_model, rig)
    after = known.with_changes([Element(point, **{kind: size})]).modes
    return beside(kind, seed, size, point, bare.modal_model, after, changed.modal_model)


class Modes(Protocol):
    """What a prediction is set beside."""

    frequency_hz: np.ndarray
    frequency_sigma_hz: np.ndarray
    damping_ratio: np.ndarray


def beside(
    kind: str, seed: int, size: float, point: int, before: ModalModel, after: ModifiedModes, measured: Modes
) -> list[list[object]]:
    """A row for each predicted mode below half the band, with the nearest one that was measured."""
    found = []
    for r, hz in enumerate(after.frequency_hz):
        m = int(np.argmin(np.abs(measured.frequency_hz - hz)))
        if hz > before.band_hz[1] / 2:
            continue
        found.append([
            seed, kind, size, point, r + 1, before.frequency_hz[after.like[r]], hz, after.frequency_sigma_hz[r],
            measured.frequency_hz[m], measured.frequency_sigma_hz[m], after.damping_ratio[r], after.damping_sigma[r],
            measured.damping_ratio[m],
        ])  # fmt: skip
    return found


def summary(rows: list[list[object]]) -> str:
    """The figures of the page."""
    columns = dict(zip(COLUMNS, zip(*rows, strict=True), strict=True))
    p, s, m, ms = (
        np.array(columns[c], float) for c in ("predicted_hz", "sigma_hz", "measured_hz", "measured_sigma_hz")
    )
    off, inside = np.abs(p / m - 1), np.abs(p - m) <= 1.96 * np.hypot(s, ms)
    zeta = np.abs(np.array(columns["predicted_zeta"], float) / np.array(columns["measured_zeta"], float) - 1)
    return (
        f"{len(set(columns['seed']))} benches, {len(rows)} modes: frequency off by {100 * np.median(off):.3f} % in the "
        f"median, {100 * off.max():.2g} % at most; {100 * inside.mean():.0f} % inside the 95 % interval; damping ratio "
        f"off by {100 * np.median(zeta):.2g} % in the median"
    )


if __name__ == "__main__":
    measure(rows_of, COLUMNS, summary, FIRST_SEED, int(sys.argv[1]), Path(sys.argv[2]))
