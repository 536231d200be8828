"""What coverage.py prints: one line a mode, and the figures outside the goal."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

GOAL = (93.0, 97.0)
INSIDE = 1.96
"""A normal number lies within this many sigmas in 95 % of all cases."""
PARAMETERS = ("f", "zeta", "Re constants", "Im constants")


def table(results: Sequence[dict], bound: NDArray[np.float64] | None) -> None:
    """Prints found, spurious and time, then errors, bound, coverage, scatter and bias of each mode.

    Args:
        results: of each seed, as coverage.one gives them.
        bound: (modes, 2) relative Cramer-Rao sigma of f and zeta, where the truth is the same for every seed.
    """
    n_modes = len(results[0]["modes"])
    whole = sum(all(m is not None for m in r["modes"]) for r in results)
    print(
        f"{len(results)} seeds: all {n_modes} modes found in {whole}; spurious modes in "
        f"{sum(r['spurious'] > 0 for r in results)} ({sum(r['spurious'] for r in results)} in all); "
        f"{np.median([r['s'] for r in results]):.2f} s of processor each"
    )
    if not n_modes:
        return
    print(
        "mode  worst f %   (bound)   worst zeta %  (bound)   in 95 %: f   zeta   constants: Re  Im   "
        "scatter/sigma: f  zeta   mean/sigma: f  zeta"
    )
    rows = [np.array([r["modes"][k] for r in results if r["modes"][k] is not None]) for k in range(n_modes)]
    for mode, of_mode in enumerate(rows):
        print(_line(mode, of_mode, None if bound is None else bound[mode]))
    _outside(rows)


def inside(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Percent of the 95 % intervals of f, zeta and the constants' real and imaginary parts that hold the truth."""
    return 100 * np.mean(np.column_stack([np.abs(rows[:, 2:4]) < INSIDE, rows[:, 4:6]]), axis=0)


def _line(mode: int, rows: NDArray[np.float64], bound: NDArray[np.float64] | None) -> str:
    if not rows.size:
        return f"{mode + 1:4d}  never found"
    worst, share = 100 * np.abs(rows[:, :2]).max(axis=0), inside(rows)
    least = ["", ""] if bound is None else [f"{100 * b:.5f}" for b in bound]
    scatter, mean = rows[:, 2:4].std(axis=0), rows[:, 2:4].mean(axis=0)
    return (
        f"{mode + 1:4d} {worst[0]:10.5f} {least[0]:>9s} {worst[1]:13.4f} {least[1]:>9s} "
        f"{share[0]:12.1f} {share[1]:6.1f} {share[2]:12.1f} {share[3]:6.1f} {scatter[0]:14.2f} {scatter[1]:8.2f}"
        f" {mean[0]:12.2f} {mean[1]:6.2f}"
    )


def _outside(rows: Sequence[NDArray[np.float64]]) -> None:
    """The figures outside the goal, beside what chance does to a true 95 % with so many seeds."""
    some = [(mode, r) for mode, r in enumerate(rows) if r.size]
    out = [
        f"{name} of mode {mode + 1}: {share:.1f}"
        for mode, r in some
        for name, share in zip(PARAMETERS, inside(r), strict=True)
        if not GOAL[0] <= share <= GOAL[1]
    ]
    chance = 100 * np.sqrt(0.95 * 0.05 / max(len(r) for _, r in some)) if some else np.nan
    print(f"outside {GOAL[0]:.0f} to {GOAL[1]:.0f} %: {', '.join(out) or 'none'} (one sigma by chance: {chance:.2f} %)")
    if some:
        every = np.concatenate([r for _, r in some])
        shares = zip(PARAMETERS, inside(every), strict=True)
        print("all modes together: " + ", ".join(f"{name} {share:.2f} %" for name, share in shares))
