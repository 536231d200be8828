"""Forces over time as a file gives them, and motion as one takes it."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.io import savemat

from modallab.core.arrays import Real
from modallab.core.errors import StorageError
from modallab.core.units import SI_UNIT, Quantity
from modallab.formats.atomic import replacing


def read_columns(path: Path) -> Real:
    """(columns, rows) of a file of numbers: .csv or .txt with commas, semicolons or spaces and # before remarks; .npy.

    Raises:
        StorageError: there is no such file, or it holds no table of numbers.
    """
    try:
        if path.suffix == ".npy":
            table = np.load(path, allow_pickle=False)
        else:
            text = path.read_text(encoding="utf-8").translate(str.maketrans(",;", "  "))
            table = np.loadtxt(text.splitlines(), ndmin=2)
        return np.atleast_2d(np.asarray(table, np.float64).T)
    except (OSError, ValueError) as error:
        raise StorageError(
            f"{path.name} holds no table of numbers: {error}",
            where=str(path),
            remedy="give a .csv or .npy file with a row for each sample and a column for each force",
        ) from error


def write_motion(path: Path, time: Real, values: Real, sigma: Real, names: Sequence[str], quantity: Quantity) -> Path:
    """Write motion (points, samples) and its deviation over time (samples,) as .csv or .mat; returns the path.

    Raises:
        StorageError: the name ends otherwise, or the file cannot be written.
    """
    if path.suffix not in (".csv", ".mat"):
        raise StorageError(f"{path.name} ends with neither .csv nor .mat", where=str(path), remedy="name it so")
    unit = SI_UNIT[quantity]
    with replacing(path) as draft:
        if path.suffix == ".mat":
            content = {"t": time, "y": values, "sigma": sigma, "points": list(names), "quantity": quantity}
            savemat(str(draft), content | {"unit": unit}, appendmat=False)
            return path
        heads = ["time [s]", *(f"{quantity} {n} [{unit}]" for n in names), *(f"sigma {n} [{unit}]" for n in names)]
        table = np.concatenate([time[None], values, sigma]).T
        np.savetxt(draft, table, fmt="%.9g", delimiter=",", header=",".join(heads), comments="")
    return path
