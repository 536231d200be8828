"""Numbers of the TDMS format that its writer and its reader share."""

from enum import IntEnum

TAG = b"TDSm"
VERSION = 4713
LEAD = 28
"""Bytes before the metadata of a segment."""

HAS_METADATA, NEW_OBJECTS, HAS_RAW, INTERLEAVED, BIG_ENDIAN, DAQMX = 1 << 1, 1 << 2, 1 << 3, 1 << 5, 1 << 6, 1 << 7


class TdsType(IntEnum):
    """Types of a property."""

    U32 = 7
    DOUBLE = 10
    STRING = 0x20


RAW_TYPES = {2: "<i2", 3: "<i4", 9: "<f4", 10: "<f8"}
"""Types of samples: the format's code -> NumPy's name. These are what devices deliver."""

Property = tuple[str, str | float | int]
