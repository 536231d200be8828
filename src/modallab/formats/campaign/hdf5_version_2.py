"""Campaign format version 2: what a device delivered, with unit and scale per channel, rig and provenance inside."""

import json
import zlib
from collections.abc import Sequence
from typing import Any, cast

import h5py
import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign, Ramp
from modallab.core.errors import FormatError
from modallab.core.frf import UNIT, Frf, FrfQuantity
from modallab.core.rig import Rig
from modallab.core.units import TESTS, Test
from modallab.core.versions import CAMPAIGN_NATIVE
from modallab.formats.campaign.hdf5_access import COPY_AGAIN, TypedAttributes, datasets, read_array
from modallab.formats.rig.rig_file import dump_rig

SAMPLE_TYPES = (np.int16, np.int32, np.float32, np.float64)
"""The types in which a device may deliver."""

_OPTIONAL_REALS = ("frequency_hz", "requested_rate_hz", "actual_rate_hz", "history_s", "ramp_s")
_CHUNK_BYTES = 1 << 20


def write_content(target: h5py.File, campaign: Campaign) -> None:
    """Write everything of a campaign into an empty file."""
    target.attrs["format_version"] = CAMPAIGN_NATIVE
    _write_text(target, "rig", dump_rig(campaign.rig))
    _write_text(target, "provenance", json.dumps(campaign.provenance, ensure_ascii=False, sort_keys=True))
    records = target.create_group("records")
    for block in campaign.blocks:
        _write_block(records, block)
    frfs = target.create_group("frfs")
    for place, frf in enumerate(campaign.frfs):
        _write_frf(frfs.create_group(f"{place:04d}"), frf)


def read_content(source: h5py.File, rig: Rig, where: str, name: str) -> Campaign:
    """Everything of a file of version 2.

    Raises:
        FormatError: something is missing, of the wrong type, or does not agree with its checksum.
    """
    records, frfs = _get_group(source, "records", where), _get_group(source, "frfs", where)
    blocks = [_read_block(key, record, f"{where}, record {key}") for key, record in datasets(records, where)]
    provenance = json.loads(_read_text(source, "provenance", where) or "{}")
    return Campaign(
        rig=rig,
        blocks=tuple(sorted(blocks, key=lambda block: block.order)),
        frfs=tuple(_read_frf(_get_group(frfs, str(key), where), f"{where}, FRF {key}") for key in frfs),
        provenance={str(key): str(value) for key, value in cast("dict[str, object]", provenance).items()},
        source=name,
    )


def read_rig_text(source: h5py.File, where: str) -> str:
    """The rig file inside a campaign, "" if there is none."""
    return _read_text(source, "rig", where) if source.attrs.get("format_version") is not None else ""


def _write_block(records: h5py.Group, block: Block) -> None:
    record = _write_sealed(records, block.name, block.samples)
    record.attrs["test"] = _fixed([block.test])[0]
    record.attrs["order"] = block.order
    record.attrs["rate_hz"] = block.rate_hz
    record.attrs["first_sample"] = block.first_sample
    record.attrs["scale"] = np.asarray(block.scale, dtype=np.float64)
    record.attrs["units"] = _fixed(block.units)
    record.attrs["channels"] = _fixed(block.channels)
    if block.level is not None:
        record.attrs["level"] = _fixed([block.level])[0]
    if block.ramp is not None:
        record.attrs["ramp"] = _fixed([block.ramp])[0]
    if block.drive_point is not None:
        record.attrs["drive_point"] = block.drive_point
    if block.also_driven:
        record.attrs["also_driven"] = np.array(block.also_driven, dtype=np.int64)
    if block.overload is not None:
        record.attrs["overload"] = np.asarray(block.overload, dtype=np.uint8)
    for name in _OPTIONAL_REALS:
        if getattr(block, name) is not None:
            record.attrs[name] = float(getattr(block, name))


def _read_block(name: str, record: h5py.Dataset, where: str) -> Block:
    facts = TypedAttributes.of(record, where)
    if record.dtype not in SAMPLE_TYPES or record.ndim != 2:
        raise FormatError(
            f"holds {record.dtype} of shape {record.shape}; allowed: (channels, samples) of int16, int32, float32, "
            "float64",
            where=where,
            remedy=COPY_AGAIN,
        )
    reals = {key: facts.real(key) if facts.has(key) else None for key in _OPTIONAL_REALS}
    return Block(
        name=name,
        test=cast("Test", facts.choice("test", *TESTS)),
        order=facts.whole("order"),
        rate_hz=facts.real("rate_hz"),
        samples=_read_sealed(record, where),
        scale=facts.reals("scale"),
        units=facts.texts("units"),
        channels=facts.texts("channels"),
        drive_point=facts.whole("drive_point") if facts.has("drive_point") else None,
        level=facts.text("level") if facts.has("level") else None,
        first_sample=facts.whole("first_sample"),
        overload=tuple(bool(x) for x in facts.reals("overload")) if facts.has("overload") else None,
        ramp=cast("Ramp", facts.choice("ramp", "straight", "cosine")) if facts.has("ramp") else None,
        also_driven=tuple(int(point) for point in facts.reals("also_driven")) if facts.has("also_driven") else (),
        **reals,
    )


def _write_frf(group: h5py.Group, frf: Frf) -> None:
    for name in ("frequency_hz", "values", "coherence", "variance"):
        if getattr(frf, name) is not None:
            _write_sealed(group, name, np.asarray(getattr(frf, name)))
    group.attrs["quantity"] = _fixed([frf.quantity])[0]
    group.attrs["outputs"] = _fixed(frf.outputs)
    # A point's id is 1 or more; 0 stands for an unknown point.
    group.attrs["output_points"] = np.array([point or 0 for point in frf.output_points], dtype=np.int64)
    group.attrs["input_points"] = np.array([point or 0 for point in frf.input_points], dtype=np.int64)
    group.attrs["averages"] = np.array(frf.averages, dtype=np.int64)
    group.attrs["damping_shift"] = frf.damping_shift


def _read_frf(group: h5py.Group, where: str) -> Frf:
    facts = TypedAttributes.of(group, where)
    arrays = {name: _read_sealed(dataset, where) for name, dataset in datasets(group, where)}
    for name in ("frequency_hz", "values"):
        if name not in arrays:
            raise FormatError(f"has no {name}", where=where, remedy=COPY_AGAIN)
    return Frf(
        frequency_hz=arrays["frequency_hz"],
        values=arrays["values"],
        quantity=cast("FrfQuantity", facts.choice("quantity", *UNIT)),
        outputs=facts.texts("outputs"),
        output_points=tuple(int(point) or None for point in facts.reals("output_points")),
        input_points=tuple(int(point) or None for point in facts.reals("input_points")),
        coherence=arrays.get("coherence"),
        variance=arrays.get("variance"),
        averages=tuple(int(count) for count in facts.reals("averages")),
        damping_shift=facts.real("damping_shift"),
    )


def _write_sealed(group: h5py.Group, name: str, values: NDArray[Any]) -> h5py.Dataset:
    """Write an array, packed, with its crc32 (of the little-endian bytes in C order) as attribute."""
    row_bytes = values.nbytes // values.shape[-1] if values.size else 1
    chunk = (*values.shape[:-1], max(1, min(values.shape[-1], _CHUNK_BYTES // max(1, row_bytes))))
    packed = {"chunks": chunk, "compression": "gzip", "shuffle": True, "fletcher32": True} if values.size else {}
    dataset = group.create_dataset(name, data=values, **cast("Any", packed))
    dataset.attrs["crc32"] = _crc32(values)
    return dataset


def _read_sealed(dataset: h5py.Dataset, where: str) -> NDArray[Any]:
    """Read an array back.

    Raises:
        FormatError: it does not agree with its checksum.
    """
    values = read_array(dataset, where)
    if _crc32(values) != TypedAttributes.of(dataset, where).whole("crc32"):
        found = "does not agree with its checksum: it was changed or damaged after it was written"
        raise FormatError(found, where=where, remedy=COPY_AGAIN)
    return values


def _write_text(target: h5py.File, name: str, text: str) -> None:
    """Write a text as an array of its UTF-8 bytes."""
    _write_sealed(target, name, np.frombuffer(text.encode("utf-8"), dtype=np.uint8))


def _read_text(source: h5py.File, name: str, where: str) -> str:
    """Read a text back, "" if there is none.

    Raises:
        FormatError: it is no text, or does not agree with its checksum.
    """
    if name not in source:
        return ""
    dataset = source[name]
    if not isinstance(dataset, h5py.Dataset) or dataset.dtype != np.uint8:
        raise FormatError(f"{name} is no text", where=where, remedy=COPY_AGAIN)
    return _read_sealed(dataset, f"{where}, {name}").tobytes().decode("utf-8")


def _get_group(parent: h5py.Group, name: str, where: str) -> h5py.Group:
    """A group by its name.

    Raises:
        FormatError: there is none.
    """
    group = parent.get(name)
    if not isinstance(group, h5py.Group):
        raise FormatError(f"has no group {name!r}", where=where, remedy=COPY_AGAIN)
    return group


def _fixed(texts: Sequence[str]) -> NDArray[np.bytes_]:
    """Texts as an attribute may hold them."""
    # Text of fixed length lies in the object's header, which HDF5 protects by a checksum; other text does not.
    encoded = [text.encode("utf-8") for text in texts]
    return np.array(encoded, dtype=f"S{max(1, *(len(text) for text in encoded), 1)}")


def _crc32(values: NDArray[Any]) -> int:
    return zlib.crc32(values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes())
