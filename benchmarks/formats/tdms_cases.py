"""TDMS files, byte by byte after NI's description of their internal structure."""

import struct
from pathlib import Path

import numpy as np
from known import RATE, G, Known, case, hit, moved

META, NEW_OBJECTS, RAW, INTERLEAVED, BIG = 2, 4, 8, 32, 64
RAW_SOURCE = 0xFFFFFFFF
TYPES = {"int16": 2, "int32": 3, "float32": 9, "float64": 10}
FORCE, A1, A2 = ("/'hit'/'force'", "/'hit'/'a1'", "/'hit'/'a2'")
UNITS = ({"unit_string": "N"}, {"unit_string": "m/s^2"}, {"unit_string": "m/s^2"})


class Time(float):
    """Seconds since 1904, written as a time stamp."""


def text(value: str, order: str = "<") -> bytes:
    data = value.encode()
    return struct.pack(order + "I", len(data)) + data


def prop(name: str, value: object, order: str = "<") -> bytes:
    if isinstance(value, str):
        return text(name, order) + struct.pack(order + "I", 0x20) + text(value, order)
    if isinstance(value, Time):
        whole, part = int(value // 1), round((value % 1) * 2**64)
        body = struct.pack("<Qq", part, whole) if order == "<" else struct.pack(">qQ", whole, part)
        return text(name, order) + struct.pack(order + "I", 0x44) + body
    if isinstance(value, int):
        return text(name, order) + struct.pack(order + "II", 7, value)
    return text(name, order) + struct.pack(order + "Id", 10, value)


def thing(
    path: str, data: np.ndarray | None = None, props: dict | None = None, order: str = "<", same: bool = False
) -> bytes:
    """One object of the metadata: without data, with an index, or with the index of the segment before."""
    index = struct.pack(order + "I", 0xFFFFFFFF)
    if same:
        index = struct.pack(order + "I", 0)
    elif data is not None:
        index = struct.pack(order + "IIIQ", 20, TYPES[data.dtype.name], 1, len(data))
    props = props or {}
    return (
        text(path, order)
        + index
        + struct.pack(order + "I", len(props))
        + b"".join(prop(k, v, order) for k, v in props.items())
    )


def segment(objects: list[bytes], raw: bytes, order: str = "<", more: int = 0, new: bool = True) -> bytes:
    meta = struct.pack(order + "I", len(objects)) + b"".join(objects) if objects else b""
    flags = (
        (META if objects else 0)
        | (NEW_OBJECTS if new else 0)
        | (RAW if raw else 0)
        | more
        | (BIG if order == ">" else 0)
    )
    return (
        b"TDSm"
        + struct.pack("<I", flags)
        + struct.pack(order + "IQQ", 4713, len(meta) + len(raw), len(meta))
        + meta
        + raw
    )


def whole(
    rows: list[np.ndarray], props: list[dict], order: str = "<", group: str = "hit", root: dict | None = None
) -> bytes:
    """A file of one segment: root, group and channels, one after the other."""
    names = [f"/'{group}'/'{n}'" for n in ("force", "a1", "a2")]
    objects = [thing("/", props=root, order=order), thing(f"/'{group}'", order=order)]
    objects += [thing(n, r, p, order) for n, r, p in zip(names, rows, props, strict=True)]
    return segment(objects, b"".join(r.astype(r.dtype.newbyteorder(order)).tobytes() for r in rows), order)


def save(folder: Path, data: bytes) -> tuple[str, ...]:
    (folder / "case.tdms").write_bytes(data)
    return ("case.tdms",)


def waved(**more: object) -> list[dict]:
    return [unit | {"wf_increment": 1 / RATE} | more for unit in UNITS]


@case("tdms")
def start_offsets(folder: Path) -> Known:
    """wf_start_offset of each channel: 0, 3 and 1 samples."""
    rows, right = moved(hit(), (0, 3, 1))
    props = [p | {"wf_start_offset": k / RATE} for p, k in zip(waved(), (0.0, 3.0, 1.0), strict=True)]
    return Known(save(folder, whole(rows, props)), (right,))


@case("tdms")
def start_times(folder: Path) -> Known:
    """wf_start_time as time stamps, 0, 0 and 4 samples; wf_start_offset 0 beside it."""
    rows, right = moved(hit(), (0, 0, 4))
    props = [
        p | {"wf_start_offset": 0.0, "wf_start_time": Time(3857600000 + k / RATE)}
        for p, k in zip(waved(), (0, 0, 4), strict=True)
    ]
    return Known(save(folder, whole(rows, props)), (right,))


@case("tdms")
def counts_with_a_line(folder: Path) -> Known:
    """int16 with one linear scale per channel, slope and intercept."""
    record = hit()
    rows, props = [], []
    for row, unit in zip(record.rows, waved(), strict=True):
        slope, zero = np.abs(row).max() / 30000, 0.05 * np.abs(row).max()
        rows.append(np.round((row - zero) / slope).astype(np.int16))
        scale = {"Type": "Linear", "Linear_Slope": slope, "Linear_Y_Intercept": zero, "Linear_Input_Source": RAW_SOURCE}
        props.append(unit | {"NI_Scaling_Status": "unscaled", "NI_Number_Of_Scales": 1} | scaled(0, scale))
    return Known(save(folder, whole(rows, props)), (record,), tolerance=4e-5)


def scaled(number: int, facts: dict) -> dict:
    facts = {("Scale_Type" if k == "Type" else k): v for k, v in facts.items()}
    return {f"NI_Scale[{number}]_{k}": v for k, v in facts.items()}


@case("tdms")
def counts_with_two_scales(folder: Path) -> Known:
    """int32, a polynomial to volts, then a line from volts to the unit."""
    record = hit()
    rows, props = [], []
    for row, unit in zip(record.rows, waved(), strict=True):
        per_volt = np.abs(row).max() / 5
        rows.append(np.round((row / per_volt - 0.25) / 1e-6).astype(np.int32))
        one = {"Type": "Polynomial", "Polynomial_Coefficients_Size": 2, "Polynomial_Coefficients[0]": 0.25}
        one |= {"Polynomial_Coefficients[1]": 1e-6, "Polynomial_Input_Source": RAW_SOURCE}
        two = {"Type": "Linear", "Linear_Slope": per_volt, "Linear_Y_Intercept": 0.0, "Linear_Input_Source": 0}
        props.append(
            unit | {"NI_Scaling_Status": "unscaled", "NI_Number_Of_Scales": 2} | scaled(0, one) | scaled(1, two)
        )
    return Known(save(folder, whole(rows, props)), (record,))


@case("tdms")
def already_scaled(folder: Path) -> Known:
    """Numbers in their unit, with the scale that made them still beside: NI_Scaling_Status says scaled."""
    record = hit()
    scale = {"Type": "Linear", "Linear_Slope": 100.0, "Linear_Y_Intercept": 1.0, "Linear_Input_Source": RAW_SOURCE}
    props = [p | {"NI_Scaling_Status": "scaled", "NI_Number_Of_Scales": 1} | scaled(0, scale) for p in waved()]
    return Known(save(folder, whole(list(record.rows), props)), (record,), rejected="(?i)scale")


@case("tdms")
def big_endian(folder: Path) -> Known:
    """Everything with the most significant byte first."""
    record = hit()
    return Known(save(folder, whole([r.astype(np.float32) for r in record.rows], waved(), ">")), (record,))


@case("tdms")
def interleaved_chunks(folder: Path) -> Known:
    """Interleaved samples, four chunks in one segment, then a segment that has no metadata at all."""
    record = hit()
    parts = [record.rows[:, k : k + 128].astype(np.float64) for k in range(0, 1024, 128)]
    paths = (FORCE, A1, A2)
    objects = [thing("/"), thing("/'hit'"), *(thing(n, r, p) for n, r, p in zip(paths, parts[0], waved(), strict=True))]
    raw = [part.T.tobytes() for part in parts]
    data = segment(objects, b"".join(raw[:4]), more=INTERLEAVED) + segment(
        [], b"".join(raw[4:]), more=INTERLEAVED, new=False
    )
    return Known(save(folder, data), (record,))


@case("tdms")
def index_as_before(folder: Path) -> Known:
    """Later segments list channels with 'as before' in another order, and one property changes."""
    record = hit()
    parts = [list(record.rows[:, k : k + 256].astype(np.float32)) for k in range(0, 1024, 256)]
    objects = [thing(n, r, p) for n, r, p in zip((FORCE, A1, A2), parts[0], waved(), strict=True)]
    data = segment([thing("/"), thing("/'hit'"), *objects], b"".join(r.tobytes() for r in parts[0]))
    for part in parts[1:]:
        order = (2, 0, 1)
        objects = [thing((FORCE, A1, A2)[k], same=True, props={"note": "later"}) for k in order]
        data += segment(objects, b"".join(part[k].tobytes() for k in order), new=True)
    return Known(save(folder, data), (record,))


@case("tdms")
def hits_in_groups(folder: Path) -> Known:
    """Two groups, one hit each, and a third of words only."""
    one, two = hit(1), hit(2)
    data = whole(list(one.rows), waved(), group="hit 1") + whole(list(two.rows), waved(), group="operator''s hit 2")
    words = ["left", "right"]
    index = struct.pack("<IIIQQ", 28, 0x20, 1, 2, 8 + 9)
    raw = struct.pack("<II", 4, 9) + b"".join(w.encode() for w in words)
    notes = [thing("/'notes'"), text("/'notes'/'text'") + index + struct.pack("<I", 0)]
    return Known(save(folder, data + segment(notes, raw)), (one, two))


@case("tdms")
def time_channel_of_stamps(folder: Path) -> Known:
    """A channel of time stamps beside the signals, no wf_increment."""
    record = hit()
    stamps = b"".join(
        struct.pack("<Qq", round((0.25 + k / RATE) % 1 * 2**64), 3857600000 + int(0.25 + k / RATE)) for k in range(1024)
    )
    index = struct.pack("<IIIQ", 20, 0x44, 1, 1024)
    objects = [thing("/"), thing("/'hit'"), text("/'hit'/'Time'") + index + struct.pack("<I", 0)]
    objects += [thing(n, r, p) for n, r, p in zip((FORCE, A1, A2), record.rows, UNITS, strict=True)]
    data = segment(objects, stamps + b"".join(r.tobytes() for r in record.rows))
    return Known(save(folder, data), (record,), rejected="(?i)time|--rate")


@case("tdms")
def daqmx_raw(folder: Path) -> Known:
    """Raw data of DAQmx: three int16 in one buffer of 6 bytes, each with a format-changing scaler and a line."""
    record = hit()
    slopes = [np.abs(r).max() / 30000 for r in record.rows]
    counts = np.array([np.round(r / s) for r, s in zip(record.rows, slopes, strict=True)]).astype("<i2")
    objects = [thing("/"), thing("/'hit'")]
    for k, (path, unit) in enumerate(zip((FORCE, A1, A2), waved(), strict=True)):
        index = struct.pack("<IIIQ", 0x1269, 0xFFFFFFFF, 1, 1024)
        index += struct.pack("<IIIIII", 1, 3, 0, 2 * k, 0, 0) + struct.pack("<II", 1, 6)
        line = {"Type": "Linear", "Linear_Slope": slopes[k], "Linear_Y_Intercept": 0.0, "Linear_Input_Source": 0}
        props = unit | {"NI_Scaling_Status": "unscaled", "NI_Number_Of_Scales": 2} | scaled(1, line)
        objects.append(
            text(path) + index + struct.pack("<I", len(props)) + b"".join(prop(a, b) for a, b in props.items())
        )
    return Known(save(folder, segment(objects, counts.T.tobytes())), (record,), rejected="(?i)daqmx", tolerance=4e-5)


@case("tdms")
def other_units(folder: Path) -> Known:
    """kN and g by unit_string; the rate from the group's description only in wf_increment of each channel."""
    record = hit()
    props = [p | {"unit_string": u} for p, u in zip(waved(), ("kN", "g", "g"), strict=True)]
    return Known(save(folder, whole([record.force / 1e3, record.a1 / G, record.a2 / G], props)), (record,))


@case("tdms")
def slower_accelerometer(folder: Path) -> Known:
    """One accelerometer at half the rate of the others: no record of one rate."""
    record = hit()
    props = waved()
    props[2]["wf_increment"] = 2 / RATE
    rows = [record.force, record.a1, record.a2[::2]]
    return Known(save(folder, whole(rows, props)), rejected=r"(?is)a2.*(rate|1000|0\.001)|(rate|1000|0\.001).*a2")
