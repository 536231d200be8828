"""Arrays and attributes of HDF5 files of other programs, as variables with names."""

from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.rig import Rig
from modallab.formats.arrays.array_map import without_singleton_axes
from modallab.formats.arrays.named import Arrays, Texts
from modallab.formats.arrays.variables import campaign_of_variables, rig_of_variables
from modallab.formats.campaign.hdf5_access import open_hdf5, read_array
from modallab.formats.options import ImportOptions


def read_hdf5_arrays(path: Path, rig: Rig, options: ImportOptions) -> Campaign:
    """One record, or one matrix of FRFs, from the datasets of a file: group.dataset, group.dataset.attribute.

    Raises:
        FormatError: no whole HDF5 file.
        DataError: arrays that are missing or do not fit.
    """
    return campaign_of_variables(*_variables(path), path, rig, options)


def draft_hdf5_arrays(path: Path, options: ImportOptions) -> Rig:
    """The rig that the records or FRFs of a file were made on, as far as its datasets say.

    Raises:
        FormatError: no whole HDF5 file.
        DataError: what a dataset is cannot be known.
    """
    return rig_of_variables(*_variables(path), path, options)


def _variables(path: Path) -> tuple[Arrays, Texts]:
    arrays: dict[str, NDArray] = {}
    texts: dict[str, tuple[str, ...]] = {}

    def keep(name: str, values: NDArray) -> None:
        if values.dtype.kind in "fiuc":
            arrays[name] = without_singleton_axes(values)
        elif values.dtype.names:
            for field in values.dtype.names:
                keep(f"{name}.{field}", values[field])
        elif values.dtype.kind in "OSU":
            texts[name] = tuple(v.decode() if isinstance(v, bytes) else str(v) for v in np.ravel(values))

    def look(name: str, item: h5py.Dataset | h5py.Group) -> None:
        name = name.replace("/", ".")
        if isinstance(item, h5py.Dataset):
            keep(name, read_array(item, str(path)))
        for key, value in item.attrs.items():
            keep(f"{name}.{key}".lstrip("."), np.asarray(value))

    with open_hdf5(path) as source:
        look("", source)
        source.visititems(look)
    return arrays, texts
