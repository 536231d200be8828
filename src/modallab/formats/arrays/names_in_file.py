"""What a file says of its own arrays: names beside a matrix or in structures say which samples are whose."""

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.formats.arrays.array_map import ArrayMap, array_named
from modallab.formats.arrays.named import COHERENCE, FREQUENCY, FRF, Arrays, Texts, usual_name

_LIST = re.compile(r"name|label|channel", re.IGNORECASE)
_TESTLAB = ".y_values.values"
_DIRECTION = re.compile(r":\+?[XYZS]$", re.IGNORECASE)


def names_in_file(arrays: Arrays, texts: Texts, rig: Rig | None, where: str) -> tuple[Arrays, Texts, ArrayMap | None]:
    """The arrays and texts with the names that the file gives to channels, and what its FRFs are, as it says it.

    Args:
        arrays: by name. FRFs that Testlab writes function by function come back as one array.
        texts: variables of text by name, each a tuple of its rows.
        rig: that the channels are looked for on; None to draft one.
        where: file, for messages.

    Raises:
        DataError: the names are not the rig's channels, or FRFs of one file differ in their lines.
    """
    functions = [
        key.removesuffix(_TESTLAB) for key, a in arrays.items() if key.endswith(_TESTLAB) and np.iscomplexobj(a)
    ]
    if functions:
        found, array_map = _of_testlab(functions, arrays, texts, rig, where)
        return found, texts, array_map
    arrays, texts = _signals_of_testlab(arrays, texts)
    frf, frequency = usual_name(arrays, FRF), usual_name(arrays, FREQUENCY)
    for key, names in texts.items():
        held = [
            a for a, values in arrays.items() if len(names) > 1 and values.shape.count(len(names)) == 1 < values.ndim
        ]
        if not _LIST.search(key) or len(set(names)) < len(names) or not held:
            continue
        if frf in held and frequency:
            coherence = usual_name(arrays, COHERENCE) or ""
            outputs = tuple(_output(name, rig) for name in names)
            return arrays, texts, ArrayMap(frf=frf, frequency=frequency, coherence=coherence, outputs=outputs)
        if len(held) == 1 and arrays[held[0]].ndim == 2:
            return *_of_columns(names, key, held[0], arrays, texts, rig, where), None
    return *_of_elements(arrays, texts), None


def _of_columns(
    names: tuple[str, ...], key: str, matrix: str, arrays: Arrays, texts: Texts, rig: Rig | None, where: str
) -> tuple[Arrays, Texts]:
    """With an array for each column of a matrix, and its unit where there is one for each."""
    columns = {name: array_named(arrays, f"{matrix}:{k}", where) for k, name in enumerate(names, start=1)}
    rest = {name: values for name, values in arrays.items() if name != matrix}
    missing = (
        [] if rig is None else [c.name for c in rig.channels if c.name not in columns and not usual_name(rest, c.name)]
    )
    if missing:
        raise DataError(
            f"{key} names the columns {', '.join(names)}; channel {', '.join(missing)} of the rig is none of them",
            where=where,
            remedy="name the channels of the rig as the file does, or say --variable CHANNEL=NAME:COLUMN for each",
        )
    units = next((t for k, t in texts.items() if "unit" in k.lower() and len(t) == len(names)), ())
    return rest | columns, dict(texts) | {f"{n}.unit": (unit,) for n, unit in zip(names, units, strict=False)}


def _of_elements(arrays: Arrays, texts: Texts) -> tuple[Arrays, Texts]:
    """With the elements of an array of structures called by their label or name, as Simulink saves a scope."""
    parts = dict.fromkeys(key.rpartition(".")[0] for key in arrays if ")." in key)
    labels = {part: texts.get(f"{part}.label") or texts.get(f"{part}.name") or () for part in parts}
    called = {f"{part}.": f"{label[0]}." for part, label in labels.items() if len(label) == 1 and label[0]}
    if len(set(called.values())) < len(called):
        return arrays, texts

    def renamed(key: str) -> str:
        part = next((part for part in called if key.startswith(part)), "")
        return called[part] + key.removeprefix(part) if part else key

    return {renamed(key): a for key, a in arrays.items()}, {renamed(key): t for key, t in texts.items()}


def _signals_of_testlab(arrays: Arrays, texts: Texts) -> tuple[Arrays, Texts]:
    """With a structure for each channel instead of one for each quantity, which holds a column for each of several."""
    found, said = dict(arrays), dict(texts)
    for key in [key for key in arrays if key.endswith(_TESTLAB)]:
        part, values = key.removesuffix(_TESTLAB), arrays[key]
        names, columns = texts.get(f"{part}.function_record.name", ()), values.reshape(len(values), -1).T
        if (
            len(names) != len(columns)
            or len(set(names)) < len(names)
            or set(names) & {k.partition(".")[0] for k in found}
        ):
            continue
        beside = {k: found.pop(k) for k in arrays if k.startswith(f"{part}.")}
        words = {k: said.pop(k) for k in texts if k.startswith(f"{part}.")}
        for k, (name, column) in enumerate(zip(names, columns, strict=True)):
            found |= {name + own.removeprefix(part): a for own, a in beside.items()} | {name + _TESTLAB: column}
            said |= {name + own.removeprefix(part): _of_column(rows, k, len(names)) for own, rows in words.items()}
    return found, said


def _of_column(rows: tuple[str, ...], k: int, columns: int) -> tuple[str, ...]:
    """Of a text for each column that of one, else all of it."""
    return rows[k : k + 1] if len(rows) == columns else rows


def _of_testlab(
    functions: list[str], arrays: Arrays, texts: Texts, rig: Rig | None, where: str
) -> tuple[Arrays, ArrayMap]:
    """FRFs as Testlab writes them: a structure for each block of functions, with axis, quantity and names beside."""
    lines = [_lines(name, arrays, where) for name in functions]
    units = {texts.get(f"{name}.y_values.quantity.label", ("",))[0] for name in functions}
    if any(one.shape != lines[0].shape or not np.allclose(one, lines[0]) for one in lines) or len(units) > 1:
        raise DataError(
            f"the FRFs {', '.join(functions)} differ in their lines or units ({', '.join(sorted(units))})",
            where=where,
            remedy="export FRFs of one analysis to one file, and the others to another",
        )
    matrices = [arrays[name + _TESTLAB].reshape(lines[0].size, -1) for name in functions]
    names = [text for name in functions for text in texts.get(f"{name}.function_record.name", ())]
    whole = np.hstack(matrices)
    if len(names) != whole.shape[1]:
        raise DataError(
            f"holds {whole.shape[1]} FRFs and {len(names)} names of them in function_record",
            where=where,
            remedy="say which is which by --map map.yaml",
        )
    outputs = tuple(_output(_response(name), rig) for name in names)
    found = {"frf": whole, "frequency": lines[0]}
    axes = ("lines", "outputs")
    return found, ArrayMap(frf="frf", frequency="frequency", axes=axes, unit=units.pop(), outputs=outputs)


def _lines(name: str, arrays: Arrays, where: str) -> NDArray[Any]:
    parts = [arrays.get(f"{name}.x_values.{key}") for key in ("start_value", "increment", "number_of_values")]
    start, step, n = (np.nan if part is None else float(np.ravel(part)[0]) for part in parts)
    if not np.isfinite([start, step, n]).all() or n != len(arrays[name + _TESTLAB]):
        raise DataError(
            f"{name}.x_values gives {n:g} lines from {start:g} Hz in steps of {step:g} Hz, for an array of "
            f"{'x'.join(map(str, arrays[name + _TESTLAB].shape))}",
            where=where,
            remedy="export the FRFs with an even axis of frequency",
        )
    return start + step * np.arange(int(n))


def _response(name: str) -> str:
    """The response of the FRF "FRF a2:+Z/force:+Z"."""
    return _DIRECTION.sub("", name.removeprefix("FRF ").partition("/")[0].strip())


def _output(name: str, rig: Rig | None) -> str | int:
    """The name of a channel, or the number of its point where the name ends with one that is no channel's."""
    known = () if rig is None else tuple(channel.name for channel in rig.responses)
    number = name.rpartition(":")[2]
    return int(number) if name not in known and number.isdigit() and int(number) > 0 else name
