"""TDMS files as NI's programs write and read them: one segment, a group a record, samples as they were delivered.

Source: NI, "TDMS File Format Internal Structure", version 2.0 (4713). Scaling properties stand as NI-DAQmx writes them:
a reader sees units, and the raw counts stay in the file.
"""

import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError
from modallab.formats.atomic import replacing
from modallab.formats.block_facts import BlockFacts
from modallab.formats.tdms.tdms_types import (
    HAS_METADATA,
    HAS_RAW,
    NEW_OBJECTS,
    RAW_TYPES,
    TAG,
    VERSION,
    Property,
    TdsType,
)

_NO_RAW = 0xFFFFFFFF
_RAW_INPUT = 0xFFFFFFFF


def write_tdms(campaign: Campaign, path: Path) -> None:
    """Write the records of a campaign, and its rig as text. FRFs have no place in the format and are left out.

    Raises:
        DataError: samples of a type the format does not know.
        StorageError, DiskFullError: the file cannot be written.
    """
    metadata, raw = _segment(campaign)
    toc = HAS_METADATA | NEW_OBJECTS | (HAS_RAW if raw else 0)
    lead = TAG + struct.pack("<IIQQ", toc, VERSION, len(metadata) + sum(map(len, raw)), len(metadata))
    with replacing(path) as draft, draft.open("wb") as out:
        out.writelines([lead, metadata, *raw])


def _segment(campaign: Campaign) -> tuple[bytes, list[bytes]]:
    objects = [_object("/", _root(campaign), None)]
    raw: list[bytes] = []
    for block in campaign.blocks:
        objects.append(_object(_path(block.name), _of_block(block), None))
        for n, channel in enumerate(block.channels):
            row = np.ascontiguousarray(block.samples[n], dtype=block.samples.dtype.newbyteorder("<"))
            objects.append(_object(_path(block.name, channel), list(_of_channel(block, n)), _index(row, block.name)))
            raw.append(row.tobytes())
    return struct.pack("<I", len(objects)) + b"".join(objects), raw


def _root(campaign: Campaign) -> list[Property]:
    return [("name", campaign.rig.name), ("modallab_rig", campaign.rig.model_dump_json())]


def _of_block(block: Block) -> list[Property]:
    return [("description", BlockFacts.of(block).text())]


def _of_channel(block: Block, n: int) -> Iterator[Property]:
    yield "unit_string", block.units[n]
    yield "wf_start_offset", 0.0
    yield "wf_increment", 1 / block.rate_hz
    yield "wf_samples", block.n_samples
    # Real numbers are there already; counts get the line that leads to their unit.
    if block.scale[n] != 1:
        yield "NI_Scaling_Status", "unscaled"
        yield "NI_Number_Of_Scales", 1
        yield "NI_Scale[0]_Scale_Type", "Linear"
        yield "NI_Scale[0]_Linear_Slope", float(block.scale[n])
        yield "NI_Scale[0]_Linear_Y_Intercept", 0.0
        yield "NI_Scale[0]_Linear_Input_Source", _RAW_INPUT


def _path(*names: str) -> str:
    return "".join("/'" + name.replace("'", "''") + "'" for name in names)


def _object(path: str, properties: list[Property], index: bytes | None) -> bytes:
    head = _text(path) + (struct.pack("<I", _NO_RAW) if index is None else index)
    return head + struct.pack("<I", len(properties)) + b"".join(map(_property, properties))


def _index(row: NDArray[np.generic], where: str) -> bytes:
    code = next((code for code, name in RAW_TYPES.items() if np.dtype(name) == row.dtype), None)
    if code is None:
        raise DataError(f"samples of type {row.dtype} have no place in TDMS", where=where, remedy="export as HDF5")
    return struct.pack("<IIIQ", 20, code, 1, len(row))


def _property(item: Property) -> bytes:
    name, value = item
    if isinstance(value, str):
        return _text(name) + struct.pack("<I", TdsType.STRING) + _text(value)
    if isinstance(value, float):
        return _text(name) + struct.pack("<Id", TdsType.DOUBLE, value)
    return _text(name) + struct.pack("<II", TdsType.U32, value)


def _text(text: str) -> bytes:
    raw = text.encode("utf-8")
    return struct.pack("<I", len(raw)) + raw
