"""Groups and channels of a TDMS file, read by npTDMS and checked here: it reads on where a file is cut off."""

import logging
import re
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError, FormatError
from modallab.formats.unit_text import normal_unit, unit_in_name

TAG = b"TDSm"
_LEAD = 28
"""Bytes before the metadata of a segment."""
_INTERLEAVED, _BIG_ENDIAN, _DAQMX = 1 << 5, 1 << 6, 1 << 7
_UNIT_PROPERTIES = ("unit_string", "NI_UnitDescription")
_COPY_AGAIN = "copy the file again, or export it again"
_NEVER_ENDED = 2**64 - 1
_KNOWN_SCALES = {"Linear", "Polynomial", "RTD", "Strain", "Table", "Thermistor", "Thermocouple", "Add", "Subtract"}
"""What npTDMS scales; by a scale that it does not know it leaves numbers unscaled, without an error."""
_SCALE = re.compile(r"NI_Scale\[(\d+)\]")
DELIVERED = ("i2", "i4", "f4", "f8")
"""Types that devices deliver and that stay as they are; others become real numbers of double precision."""


@dataclass(frozen=True, eq=False, slots=True)
class TdmsChannel:
    """One channel of a group.

    Attributes:
        name: of it.
        unit: normal; "" where the file says none.
        properties: as written; a time stamp is one of npTDMS.
        samples: (n,) whole or real numbers as delivered, or time stamps (n,) as s after the first.
        scale: unit per number.
    """

    name: str
    unit: str
    properties: dict[str, Any]
    samples: NDArray[Any]
    scale: float


@dataclass(frozen=True, eq=False, slots=True)
class TdmsGroup:
    """A group: its channels of numbers by name, and the names of those that hold texts or nothing."""

    name: str
    description: str
    channels: dict[str, TdmsChannel] = field(default_factory=dict[str, TdmsChannel])
    others: list[str] = field(default_factory=list[str])


def read_tdms_groups(path: Path) -> tuple[TdmsGroup, ...]:
    """The groups that hold channels of numbers, in the order of the file.

    Raises:
        FormatError: no TDMS file, cut off or damaged.
        DataError: a channel is scaled in a way that is not known.
    """
    # Imported here: it takes longer than most imports of other formats.
    import nptdms
    from nptdms.log import log_manager

    log_manager.set_level(logging.CRITICAL)
    where = str(path)
    flags = _check_segments(path)
    try:
        with (
            path.open("rb") as source,
            nptdms.TdmsFile(source, raw_timestamps=True, read_metadata_only=True, keep_open=True) as found,
        ):
            _check_chunks(found, flags, where)
            size = path.stat().st_size
            _check_scales(found.properties, size, where)
            groups = [_group(group, size, where) for group in found.groups()]
    except (FormatError, DataError):
        raise
    except Exception as error:  # On damaged files npTDMS raises nearly every type there is.
        raise FormatError(
            f"is damaged: {str(error) or type(error).__name__}", where=where, remedy=_COPY_AGAIN
        ) from error
    return tuple(group for group in groups if group.channels)


def _check_segments(path: Path) -> int:
    """The flags of the last segment.

    Raises:
        FormatError: something else stands where a segment should begin, or the file ends within one.
    """
    size, at, flags, where = path.stat().st_size, 0, 0, str(path)
    with path.open("rb") as source:
        while at < size:
            source.seek(at)
            lead = source.read(_LEAD)
            if lead[:4] != TAG:
                raise FormatError(f"has no segment at byte {at}", where=where, remedy=_COPY_AGAIN)
            if len(lead) < _LEAD:
                raise FormatError("is cut off", where=where, remedy=_COPY_AGAIN)
            (flags,) = struct.unpack_from("<I", lead, 4)
            length, raw = struct.unpack_from(">QQ" if flags & _BIG_ENDIAN else "<QQ", lead, 12)
            if length == _NEVER_ENDED:
                raise FormatError(
                    "its last segment was never finished: the program that wrote it ended before",
                    where=where,
                    remedy="open it in LabVIEW or DIAdem and save it again, or export CSV",
                )
            if at + _LEAD + length > size or raw > length:
                raise FormatError("is cut off", where=where, remedy=_COPY_AGAIN)
            at += _LEAD + length
    return flags


def _check_chunks(found: Any, flags: int, where: str) -> None:
    # Of samples that alternate a last chunk may hold fewer; of others nobody knows whose are missing.
    status = found.file_status.channel_statuses or {}
    if not flags & (_INTERLEAVED | _DAQMX) and any(s.read_length != s.expected_length for s in status.values()):
        raise FormatError("holds part of a chunk of samples", where=where, remedy=_COPY_AGAIN)


def _check_scales(properties: dict[str, Any], size: int, where: str) -> None:
    # npTDMS makes an entry of each scale that is announced: a damaged count would ask for more memory than there is.
    places = [int(m.group(1)) + 1 for m in map(_SCALE.match, properties) if m is not None]
    count = max([int(properties.get("NI_Number_Of_Scales", 0)), *places])
    if count > size:
        raise FormatError(f"announces {count} scales in {size} bytes", where=where, remedy=_COPY_AGAIN)


def _group(group: Any, size: int, where: str) -> TdmsGroup:
    found = TdmsGroup(str(group.name), str(group.properties.get("description", "")))
    _check_scales(group.properties, size, f"{where}, group {group.name}")
    for channel in group.channels():
        place = f"{where}, group {group.name}, channel {channel.name}"
        # A damaged count would ask for more memory than there is.
        if len(channel) > size:
            raise FormatError(f"announces {len(channel)} samples in {size} bytes", where=place, remedy=_COPY_AGAIN)
        _check_scales(channel.properties, size, place)
        read = _samples(channel, place) if len(channel) else None
        if read is None:
            found.others.append(str(channel.name))
        else:
            name, properties = str(channel.name), dict(channel.properties)
            found.channels[name] = TdmsChannel(name, _unit(name, properties), properties, *read)
    return found


def _unit(name: str, properties: dict[str, Any]) -> str:
    """The unit that a channel's properties say, else the one in its name."""
    units = (normal_unit(str(properties.get(key, ""))) for key in _UNIT_PROPERTIES)
    return next((unit for unit in units if unit), unit_in_name(name))


def _samples(channel: Any, where: str) -> tuple[NDArray[Any], float] | None:
    """Numbers as delivered and the unit per number; None of a channel of texts."""
    slope = _slope(channel.properties, where)
    raw: Any = channel.read_data(scaled=slope is None)
    if isinstance(raw, dict):  # What DAQmx streamed has its scale beside it.
        raw, slope = channel.read_data(scaled=True), None
    if hasattr(raw, "second_fractions"):
        return _since_first(raw), 1.0
    values = np.asarray(raw)
    if values.dtype.kind not in "biuf":
        return None
    values = values.astype(values.dtype.newbyteorder("="), copy=False)
    kept = values if values.dtype.str[1:] in DELIVERED else values.astype(np.float64)
    return kept, 1.0 if slope is None else slope


def _since_first(stamps: Any) -> NDArray[np.float64]:
    seconds = np.asarray(stamps["seconds"], np.int64)
    return (seconds - seconds[0]).astype(np.float64) + np.asarray(stamps["second_fractions"], np.float64) / 2**64


def _slope(properties: dict[str, Any], where: str) -> float | None:
    """Unit per number where that is all of the scaling; None where npTDMS is to scale.

    Raises:
        DataError: a scale that npTDMS does not know.
    """
    count = properties.get("NI_Number_Of_Scales", 0)
    # Numbers that are scaled already keep the description of how they were.
    if properties.get("NI_Scaling_Status", "unscaled") == "scaled":
        return 1.0
    kinds = [str(properties[key]) for key in properties if key.startswith("NI_Scale[") and key.endswith("]_Scale_Type")]
    unknown = [kind for kind in kinds if kind not in _KNOWN_SCALES | {"AdvancedAPI"}]
    if unknown:
        found = f"is scaled by {unknown[0]}, which is not known here"
        raise DataError(found, where=where, remedy="export scaled values from LabVIEW or DIAdem")
    if not kinds and not count:
        return None
    slope = properties.get("NI_Scale[0]_Linear_Slope")
    offset = properties.get("NI_Scale[0]_Linear_Y_Intercept", 0.0)
    alone = kinds == ["Linear"] and count == 1
    return float(slope) if alone and offset == 0 and isinstance(slope, float) else None
