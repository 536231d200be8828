"""TDMS files as NI's programs write them: a group a record, samples as they were delivered.

Scaling properties stand as NI-DAQmx writes them: a reader sees units, and the raw counts stay in the file.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError
from modallab.formats.atomic import replacing
from modallab.formats.block_facts import BlockFacts
from modallab.formats.tdms.tdms_read import DELIVERED

_VERSION = 4713
_RAW_INPUT = 0xFFFFFFFF


def write_tdms(campaign: Campaign, path: Path) -> None:
    """Write the records of a campaign, and its rig as text. FRFs have no place in the format and are left out.

    Raises:
        DataError: samples of a type the format does not know.
        StorageError, DiskFullError: the file cannot be written.
    """
    # Imported here: it takes longer than most imports of other formats.
    import nptdms

    about = {"name": campaign.rig.name, "modallab_rig": campaign.rig.model_dump_json()}
    objects = [nptdms.RootObject(about), *(one for block in campaign.blocks for one in _objects(block))]
    with replacing(path) as draft, nptdms.TdmsWriter(draft, version=_VERSION) as file:
        file.write_segment(objects)


def _objects(block: Block) -> Iterator[Any]:
    import nptdms

    if block.samples.dtype.str[1:] not in DELIVERED:
        found = f"samples of type {block.samples.dtype} have no place in TDMS"
        raise DataError(found, where=block.name, remedy="export as HDF5")
    rows = block.samples.astype(block.samples.dtype.newbyteorder("<"), copy=False)
    yield nptdms.GroupObject(block.name, {"description": BlockFacts.of(block).text()})
    for n, channel in enumerate(block.channels):
        yield nptdms.ChannelObject(block.name, channel, np.ascontiguousarray(rows[n]), dict(_of_channel(block, n)))


def _of_channel(block: Block, n: int) -> Iterator[tuple[str, Any]]:
    from nptdms.types import Uint32

    yield "unit_string", block.units[n]
    yield "wf_start_offset", 0.0
    yield "wf_increment", 1 / block.rate_hz
    yield "wf_samples", block.n_samples
    # Real numbers are there already; counts get the line that leads to their unit.
    if block.scale[n] != 1:
        yield "NI_Scaling_Status", "unscaled"
        yield "NI_Number_Of_Scales", Uint32(1)
        yield "NI_Scale[0]_Scale_Type", "Linear"
        yield "NI_Scale[0]_Linear_Slope", float(block.scale[n])
        yield "NI_Scale[0]_Linear_Y_Intercept", 0.0
        yield "NI_Scale[0]_Linear_Input_Source", Uint32(_RAW_INPUT)
