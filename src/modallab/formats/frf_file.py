"""FRFs as a file that other programs read, and the rig that FRFs without one are of."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.io import savemat

from modallab.core.block import Campaign
from modallab.core.errors import StorageError
from modallab.core.frf import UNIT, Frf, FrfQuantity
from modallab.core.rig import Channel, Point, Rig
from modallab.formats.atomic import replacing
from modallab.formats.exporter import write_export

OUTPUT_UNIT: dict[FrfQuantity, tuple[str, str]] = {
    "receptance": ("displacement", "m"),
    "mobility": ("velocity", "m/s"),
    "inertance": ("acceleration", "m/s^2"),
}
FORMATS = {".uff": "uff", ".h5": "hdf5", ".mat": "mat"}


def write_frf(path: Path, frf: Frf, rig: Rig) -> None:
    """Write FRFs: a universal file (.uff), MATLAB's (.mat, with the deviation of each line) or a campaign file (.h5).

    Raises:
        StorageError: the name ends otherwise, or the file cannot be written.
    """
    if path.suffix not in FORMATS:
        raise StorageError(f"{path.name} ends with none of {', '.join(FORMATS)}", where=str(path), remedy="name it so")
    if path.suffix != ".mat":
        write_export(Campaign(rig, (), (frf,), source="model"), path, FORMATS[path.suffix])
        return
    sigma = {} if frf.variance is None else {"sigma": np.sqrt(frf.variance)}
    points = {"outputs": list(frf.output_points), "inputs": list(frf.input_points)}
    about = {"quantity": frf.quantity, "unit": UNIT[frf.quantity], **points}
    with replacing(path) as draft:
        savemat(str(draft), {"f": frf.frequency_hz, "H": frf.values, **sigma, **about}, appendmat=False)


def rig_of(frf: Frf) -> Rig:
    """A rig of FRFs between points whose places are not known."""
    to, of = ([p for p in points if p is not None] for points in (frf.output_points, frf.input_points))
    return rig_without_places(frf.outputs, to, of, frf.quantity)


def rig_without_places(names: Sequence[str], to: Sequence[int], of: Sequence[int], quantity: FrfQuantity) -> Rig:
    """A rig of outputs and points whose places are not known: the numbers of the points stand for them in figures."""
    measured, unit = OUTPUT_UNIT[quantity]
    force = Channel.model_validate({"index": 0, "name": "force", "quantity": "force", "unit": "N"})
    responses = [
        Channel.model_validate({"index": i, "name": name, "quantity": measured, "unit": unit, "point": point})
        for i, (name, point) in enumerate(zip(names, to, strict=True), 1)
    ]
    points = tuple(Point(id=p, x_m=float(p)) for p in sorted({*to, *of}))
    return Rig(name="FRFs from arrays", model="unknown", points=points, channels=(force, *responses))
