"""Campaign files: HDF5 of version 1 (int16 counts, one scale) or version 2 (what a device delivers)."""

from pathlib import Path
from typing import Any, cast

import h5py
import numpy as np

from modallab.errors import FormatError
from modallab.exchange.rig_file import read_rig
from modallab.schema.block import Block, Campaign
from modallab.schema.rig import Rig
from modallab.schema.units import Test


def read_campaign(path: Path, rig: Rig | None = None) -> Campaign:
    """Read a campaign: a folder with `rig.yaml` and `campaign.h5`, or an HDF5 file.

    Args:
        path: folder or file.
        rig: the rig, if it is neither in the file nor beside it.

    Raises:
        FormatError: the file is not a campaign, is cut off, or is of a newer version.
        RigError: there is no rig, or it is not valid.
    """
    path = Path(path)
    file = path / "campaign.h5" if path.is_dir() else path
    try:
        with h5py.File(file) as source:
            rig = rig if rig is not None else read_rig(file.parent / "rig.yaml")
            volts = float(cast("Any", source.attrs["volts_per_count"]))
            blocks = [_read_block(name, cast("h5py.Dataset", source[name]), volts, rig) for name in source]
    except OSError as error:
        raise FormatError(f"cannot be read as HDF5: {error}", where=str(file), remedy="copy the file again") from error
    return Campaign(rig, tuple(sorted(blocks, key=lambda b: b.order)), source=str(path))


def _read_block(name: str, record: h5py.Dataset, volts: float, rig: Rig) -> Block:
    facts = cast("dict[str, Any]", dict(record.attrs))
    samples = np.asarray(record[()])
    return Block(
        name=name,
        test=cast("Test", str(facts["test"])),
        order=int(facts["order"]),
        rate_hz=float(facts["sample_rate_hz"]),
        samples=samples,
        scale=np.full(len(samples), volts),
        units=("V",) * len(samples),
        channels=tuple(c.name for c in rig.channels),
        drive_point=int(facts["drive_point"]),
        level=str(facts["level"]) if "level" in facts else None,
        frequency_hz=float(facts["frequency_hz"]) if "frequency_hz" in facts else None,
    )
