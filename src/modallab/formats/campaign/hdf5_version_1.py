"""Campaign format version 1: one int16 dataset a record, one scale in volts for the whole file."""

from typing import cast

import h5py
import numpy as np

from modallab.core.block import Block
from modallab.core.errors import FormatError
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.formats.campaign.hdf5_access import COPY_AGAIN, TypedAttributes, datasets, read_array


def read_blocks(source: h5py.File, rig: Rig, where: str) -> tuple[Block, ...]:
    """The records of a file of version 1, in the order of time.

    Raises:
        FormatError: the layout is not that of version 1.
    """
    volts_per_count = TypedAttributes.of(source, where).real("volts_per_count")
    blocks = [_block(name, record, volts_per_count, rig, where) for name, record in datasets(source, where)]
    return tuple(sorted(blocks, key=lambda block: block.order))


def _block(name: str, record: h5py.Dataset, volts_per_count: float, rig: Rig, file: str) -> Block:
    where = f"{file}, record {name}"
    if record.dtype != np.int16 or record.ndim != 2:
        raise FormatError(
            f"holds {record.dtype} of shape {record.shape}, not int16 (channels, samples)",
            where=where,
            remedy="write other types as campaign format version 2",
        )
    facts = TypedAttributes.of(record, where)
    samples = read_array(record, where)
    names = tuple(channel.name for channel in rig.channels)
    # Version 1 names no channels: rows stand in rig order, and a wrong number of rows must stay visible.
    channels = names if len(samples) == len(names) else tuple(f"row {k}" for k in range(len(samples)))
    return Block(
        name=name,
        test=cast("Test", facts.choice("test", "impact", "sine")),
        order=facts.whole("order"),
        rate_hz=facts.real("sample_rate_hz"),
        samples=samples,
        scale=np.full(len(samples), volts_per_count),
        units=("V",) * len(samples),
        channels=channels,
        drive_point=facts.whole("drive_point") if facts.has("drive_point") else None,
        level=facts.text("level") if facts.has("level") else None,
        frequency_hz=facts.real("frequency_hz") if facts.has("frequency_hz") else None,
    )


def is_counts(source: h5py.File) -> bool:
    """Whether the file is of version 1, which does not say so itself."""
    return "volts_per_count" in source.attrs


def reject_foreign(where: str) -> FormatError:
    """The error for HDF5 of another kind."""
    return FormatError(
        "is HDF5, but no campaign: it has neither format_version nor volts_per_count", where=where, remedy=COPY_AGAIN
    )
