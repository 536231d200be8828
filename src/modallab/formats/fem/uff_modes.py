"""Modes of a universal file as those of a model: datasets 55 and 2414 at nodes of 15, 2411."""

from pathlib import Path

import numpy as np

from modallab.core.digits import percent_text
from modallab.core.errors import DataError
from modallab.formats.modes import NodeModes
from modallab.formats.uff.uff_results import NodeMode, read_results

COMPLEX = 0.1
"""Imaginary part over the whole from which a shape is no normal mode's."""


def read_uff_modes(path: Path) -> NodeModes:
    """Modes of the first shapes at all nodes, at unit modal mass.

    Raises:
        FormatError: no universal file, or a damaged one.
        DataError: it holds no modes, no modal masses, or complex ones.
    """
    results = read_results(path)
    modes = sorted(results.modes, key=lambda mode: mode.frequency_hz)
    if not modes:
        raise DataError("holds no modes", where=str(path), remedy="export them as dataset 55 or 2414")
    masses = np.array([mode.modal_mass_kg for mode in modes])
    if not np.all(masses > 0):
        raise DataError(
            "says no modal mass of its modes, so that their size is unknown",
            where=str(path),
            remedy="export them with modal mass, or at unit modal mass and with modal mass 1",
        )
    nodes = sorted(set.intersection(*(set(mode.at) for mode in modes)))
    at = {n: np.array([_turned(mode)[n] for mode in modes]) / np.sqrt(masses)[:, None] for n in nodes}
    _check_real(modes, str(path))
    hz, zeta = (np.array([getattr(mode, name) for mode in modes]) for name in ("frequency_hz", "damping_ratio"))
    return NodeModes(path.stem, hz, at, dict(results.geometry.points), np.where(zeta > 0, zeta, np.nan))


def _turned(mode: NodeMode) -> dict[int, np.ndarray]:
    return {node: np.real(motion) for node, motion in mode.at.items()}


def _check_real(modes: list[NodeMode], where: str) -> None:
    for mode in modes:
        motion = np.concatenate(list(mode.at.values()))
        share = float(np.linalg.norm(motion.imag) / max(np.linalg.norm(motion), np.finfo(float).tiny))
        if share > COMPLEX:
            raise DataError(
                f"the mode at {mode.frequency_hz:.4g} Hz is complex: {percent_text(share)} of it is imaginary",
                where=where,
                remedy="export normal modes",
            )
