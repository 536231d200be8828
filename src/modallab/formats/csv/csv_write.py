"""A campaign as a folder of CSV files that any program reads: a file a record, FRFs, modes, and the rig."""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign
from modallab.core.errors import StorageError
from modallab.core.frf import UNIT, Frf
from modallab.core.model import ModalModel
from modallab.formats.atomic import replacing
from modallab.formats.block_facts import BlockFacts
from modallab.formats.rig.rig_file import write_rig
from modallab.formats.uff.uff_lines import physical

Column = NDArray[np.float64]


def write_csv(campaign: Campaign, folder: Path, models: Sequence[ModalModel] = ()) -> None:
    """Write every record, FRF and model of a campaign, with 17 digits, so that every number is read back bit for bit.

    Samples are in the unit of their record. The first line of a record's file is a remark with its name, test, rate and
    drive point.

    Raises:
        StorageError, DiskFullError: the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(f"cannot be made: {error.strerror}", where=str(folder), remedy="name a folder") from error
    write_rig(campaign.rig, folder / "rig.yaml")
    for block in campaign.blocks:
        _write(folder / f"{block.name}.csv", _record(block), BlockFacts.of(block).text())
    for n, frf in enumerate(campaign.frfs, start=1):
        _write(folder / f"frf_{n}.csv", _frf(frf), f"{frf.quantity} in {UNIT[frf.quantity]}")
    for model in models:
        name = f"modes_{model.test or 'frf'}.csv"
        _write(folder / name, _modes(model), json.dumps({"method": model.method, "band_hz": model.band_hz}))


def _record(block: Block) -> dict[str, Column]:
    columns = {"time [s]": np.arange(block.n_samples) / block.rate_hz}
    for name, unit, values in zip(block.channels, block.units, physical(block), strict=True):
        columns[f"{name} [{unit}]"] = values
    return columns


def _frf(frf: Frf) -> dict[str, Column]:
    columns = {"frequency [Hz]": frf.frequency_hz}
    for i, output in enumerate(frf.outputs):
        for j, point in enumerate(frf.input_points):
            columns |= _parts(f"{output}/p{point}", frf.values[i, j])
            if frf.coherence is not None:
                columns[f"coherence {output}/p{point}"] = frf.coherence[i, j]
    return columns


def _modes(model: ModalModel) -> dict[str, Column]:
    columns = {
        "frequency [Hz]": model.frequency_hz,
        "frequency sigma [Hz]": model.frequency_sigma_hz,
        "damping ratio": model.damping_ratio,
        "damping sigma": model.damping_sigma,
    }
    if model.shapes is not None:
        for name, shape in zip(model.outputs, model.shapes.T, strict=True):
            columns |= _parts(f"phi {name} [kg^-1/2]", shape)
    return columns


def _parts(name: str, values: NDArray[np.complex128]) -> dict[str, Column]:
    return {f"re {name}": values.real, f"im {name}": values.imag}


def _write(path: Path, columns: dict[str, Column], remark: str) -> None:
    rows: Iterable[tuple[float, ...]] = zip(*(column.tolist() for column in columns.values()), strict=True)
    with replacing(path) as draft, draft.open("w", encoding="utf-8", newline="\n") as out:
        out.write(f"# {remark}\n{','.join(columns)}\n")
        for row in rows:
            # repr gives the shortest digits that are read back as the same number.
            out.write(",".join(map(repr, row)) + "\n")
