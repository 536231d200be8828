"""Two structures coupled, and what is not of a structure taken away: predicted from measured FRFs, then measured.

    python benchmarks/coupled.py 10 benchmarks/results/coupled.csv [case]

A is a plate; B, another plate or a tube, is joined to it rigidly along z at a corner, or at both driven points. The
reverse: A from a measurement with sensors of 10 g and a stinger at the driven corner (20 g, 500 N/m), and from the
measurement of both by the model of B. All are as built, as in `modified_structures.py`. A row is a mode below half the
band.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.linalg import block_diag, eigvalsh, null_space

from by_seed import measure
from modallab.modification.attachments import AttachedPart, Element
from modallab.modification.coupled import CouplingToStructure
from modallab.modification.known import KnownStructure
from modallab.verification.verify import frac
from modified_structures import TOLERANCE, Bench

FIRST_SEED, THICKER = 10001, 1.3
SENSOR_KG, STINGER_KG, STINGER_N_PER_M = 0.01, 0.02, 500.0
FAR = 0.05
"""Relative distance from which a predicted mode, whose interval is not as wide, was not identified again."""
COLUMNS = (
    "seed", "case", "mode", "predicted_hz", "sigma_hz", "measured_hz", "measured_sigma_hz", "predicted_zeta",
    "measured_zeta", "frac_median", "frac_least", "conditioning",
)  # fmt: skip


def joined(a: Bench, b: Bench, pairs: list[tuple[int, int]]) -> Bench:
    """The matrices of both, held together along z; sensors and hits are those of A."""
    rows = [np.append(a.row(a.places[p - 1], "z"), -b.row(b.places[q - 1], "z")) for p, q in pairs]
    free = null_space(np.array(rows))
    more = len(b.mass)
    return a.like(
        *(free.T @ block_diag(*both) @ free for both in zip(a.matrices, b.matrices, strict=True)),
        lambda at, axis: np.append(a.row(at, axis), np.zeros(more)) @ free,
    )


def loaded(a: Bench) -> tuple[Bench, list[AttachedPart]]:
    """A with a mass where each sensor is, and a stinger; and what takes them away."""
    mass, stiffness, damping = a.matrices
    rows = np.array([a.row(at, "z") for at in a.sensors])
    stinger = a.row(a.places[a.hits[0] - 1], "z")
    mass = mass + SENSOR_KG * rows.T @ rows + STINGER_KG * np.outer(stinger, stinger)
    other = a.like(mass, stiffness + STINGER_N_PER_M * np.outer(stinger, stinger), damping, a.row)
    away: list[AttachedPart] = [Element((p, "z"), mass=-SENSOR_KG) for p in range(1, len(a.places) + 1)]
    return other, [*away, Element((a.hits[0], "z"), mass=-STINGER_KG, spring=-STINGER_N_PER_M)]


def cases(seed: int) -> Iterator[tuple[str, Bench, list[AttachedPart], Bench]]:
    """Its name, what is measured, what is changed of the model, and what is measured to compare."""
    a, b = Bench(2 * seed), Bench(2 * seed + (1 if seed % 2 else 1000), THICKER)
    n, m = len(a.places), len(b.places)
    one, two = [(n, m)], [(n, m), (n // 2, m // 2)]
    (heavy, away), once, twice = loaded(a), joined(a, b, one), joined(a, b, two)
    for bench in (every := (a, b, heavy, once, twice)):
        bench.high_hz = edge(a, *every)
    other = known_of(b)[0]
    yield "joined at one point", a, [held(other, one)], once
    yield "joined at two points", a, [held(other, two)], twice
    yield "sensors and stinger taken away", heavy, away, a
    yield "the other structure taken away", once, [held(other, one, -1)], a


def edge(a: Bench, *every: Bench) -> float:
    """Hz of a band of about ten modes of A that ends where none of them resonates: in the widest gap."""
    hz = np.sort(np.concatenate([np.sqrt(np.abs(eigvalsh(b.stiffness, b.mass))) for b in every])) / 2 / np.pi
    hz = hz[(hz >= a.omega[8] / 2 / np.pi) & (hz <= a.omega[13] / 2 / np.pi)]
    widest = int(np.argmax(hz[1:] / hz[:-1]))
    return float(np.sqrt(hz[widest] * hz[widest + 1]))


def held(other: KnownStructure, pairs: list[tuple[int, int]], sign: int = 1) -> CouplingToStructure:
    """The other structure at pairs of points."""
    along = [((p, "z"), (q, "z")) for p, q in pairs]
    return CouplingToStructure(other.structure, along, sign=sign, samples=other.samples)


def known_of(bench: Bench) -> tuple[KnownStructure, np.ndarray, np.ndarray]:
    """The structure as identified, and the FRFs that it was identified from."""
    measured = bench.frfs()
    model = bench.identified(measured)
    rig = bench.rig.model_copy(update={"tolerance": TOLERANCE})
    return KnownStructure(model, rig), measured.frf.frequency_hz, measured.frf.values


def rows_of(seed: int, only: str = "") -> list[list[object]]:
    """Predicted and measured modes of one pair of structures, of all cases or one."""
    found = []
    for case, bench, changes, truth in cases(seed):
        if only not in case:
            continue
        predicted = known_of(bench)[0].with_changes(changes)
        (after, hz, frfs), modes = known_of(truth), predicted.modes
        low = hz <= bench.high_hz / 2
        agree = frac(frfs[..., low], predicted.frf(hz[low], quantity="inertance", sigma=False).values)
        for r in np.flatnonzero(modes.frequency_hz <= bench.high_hz / 2):
            m = int(np.argmin(np.abs(after.model.frequency_hz - modes.frequency_hz[r])))
            measured = after.model.frequency_hz[m], after.model.frequency_sigma_hz[m], after.model.damping_ratio[m]
            near = max(FAR * modes.frequency_hz[r], 1.96 * modes.frequency_sigma_hz[r])
            if abs(measured[0] - modes.frequency_hz[r]) > near:
                measured = (np.nan,) * 3
            found.append([
                seed, case, int(r) + 1, modes.frequency_hz[r], modes.frequency_sigma_hz[r], *measured[:2],
                modes.damping_ratio[r], measured[2], float(np.median(agree)), float(agree.min()),
                predicted.conditioning or 1.0,
            ])  # fmt: skip
    return found


def summary(rows: list[list[object]]) -> str:
    """The figures of the page, a line for each case."""
    lines = []
    for case in dict.fromkeys(str(r[1]) for r in rows):
        own = [dict(zip(COLUMNS, r, strict=True)) for r in rows if r[1] == case]
        p, s, m, ms = (
            np.array([r[c] for r in own], float)
            for c in ("predicted_hz", "sigma_hz", "measured_hz", "measured_sigma_hz")
        )
        off, agree = np.abs(p / m - 1), np.array([[r["frac_median"], r["frac_least"]] for r in own], float)
        inside = np.abs(p - m) <= 1.96 * np.hypot(s, ms)
        lines.append(
            f"{case}: {len({r['seed'] for r in own})} pairs, {len(own)} modes, {np.isnan(m).sum()} not measured; "
            f"frequency off by {100 * np.nanmedian(off):.3f} % in the median, {100 * np.nanmax(off):.2g} % at most, "
            f"{100 * np.mean(off <= 1e-3):.0f} % within 0.1 %, {100 * inside.mean():.0f} % inside the 95 % interval; "
            f"FRAC {np.median(agree[:, 0]):.4f} in the median, {agree[:, 1].min():.3f} at least"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    count, out, only = int(sys.argv[1]), Path(sys.argv[2]), " ".join(sys.argv[3:])
    measure(lambda seed: rows_of(seed, only), COLUMNS, summary, FIRST_SEED, count, out)
