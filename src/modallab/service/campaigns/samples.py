"""Samples of a block as they stand on the disk."""

import numpy as np

from modallab.service.context import Service
from modallab.storage.records import BlockRecord
from modallab.storage.samples import Samples, open_samples


def read_samples(service: Service, block: BlockRecord) -> Samples:
    """(channels, count) samples, little-endian, exactly as the device delivered them.

    Raises:
        StorageError: they cannot be read.
    """
    with open_samples(service.folder / "runs" / f"{block.run}.h5") as reader:
        samples = reader.read(block.offset, block.count)
    return np.ascontiguousarray(samples, dtype=samples.dtype.newbyteorder("<"))
