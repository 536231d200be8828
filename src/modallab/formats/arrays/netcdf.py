"""Time records of Rattlesnake: netCDF4, which is HDF5."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.errors import FormatError
from modallab.core.rig import Rig
from modallab.formats.arrays.named import ALL, RATE, campaign_of_arrays
from modallab.formats.options import ImportOptions

SAMPLES, SAMPLE_RATE = "time_data", "sample_rate"


def is_rattlesnake(path: Path) -> bool:
    """Whether an HDF5 file holds what Rattlesnake streams."""
    try:
        with h5py.File(path, "r") as source:
            return isinstance(source.get(SAMPLES), h5py.Dataset) and SAMPLE_RATE in source.attrs
    except OSError:
        return False


def read_rattlesnake(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """One record: the channels in rig order, in the rig's units, or volts if the options say so.

    Raises:
        FormatError: the file cannot be read to its end.
        DataError: not as many channels as the rig has.
    """
    try:
        with h5py.File(path, "r") as source:
            # A new variable has as many columns as were streamed; h5py's types do not know that it is a dataset.
            samples: NDArray[Any] = np.asarray(source[SAMPLES])
            rate = np.asarray(source.attrs[SAMPLE_RATE], np.float64)
    except (OSError, KeyError) as error:
        raise FormatError(
            f"is no whole netCDF4 file: {error}", where=str(path), remedy="copy the file again"
        ) from error
    return campaign_of_arrays({ALL: samples, RATE: rate}, path.stem, rig, options, str(path))
