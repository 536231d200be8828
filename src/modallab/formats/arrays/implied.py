"""The map that a file implies: a list of names beside a matrix says which column is which channel."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.formats.arrays.array_map import ArrayMap
from modallab.formats.arrays.named import COHERENCE, FREQUENCY, FRF, RATE, STEP, TIME, Arrays, usual_name
from modallab.formats.draft import FORCE_NAMES

Texts = Mapping[str, tuple[str, ...]]

_LIST = re.compile(r"name|label|channel", re.IGNORECASE)
_TESTLAB = ".y_values.values"
_DIRECTION = re.compile(r":\+?[XYZS]$", re.IGNORECASE)


def implied_map(arrays: Arrays, texts: Texts, rig: Rig | None, where: str) -> tuple[Arrays, ArrayMap | None]:
    """The arrays, and what they are as the file's own lists of names say it; None where it holds no such list.

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
        return _of_testlab(functions, arrays, texts, rig, where)
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
            return arrays, ArrayMap(frf=frf, frequency=frequency, coherence=coherence, outputs=outputs)
        if len(held) == 1 and arrays[held[0]].ndim == 2:
            columns = {name: f"{held[0]}:{k}" for k, name in enumerate(names, start=1)}
            return arrays, _of_records(columns, key, arrays, rig, where)
    columns = _of_elements(arrays, texts)
    return arrays, _of_records(columns, "a structure", arrays, rig, where) if columns else None


def _of_elements(arrays: Arrays, texts: Texts) -> dict[str, str]:
    """The samples in each element of an array of structures, by its label or name, as Simulink saves a scope."""
    parts = [(key, key.rpartition(".")[0]) for key, values in arrays.items() if values.ndim == 1 and values.size > 1]
    labels = {key: texts.get(f"{part}.label") or texts.get(f"{part}.name") for key, part in parts if part[-1:] == ")"}
    return {label[0]: key for key, label in labels.items() if label and len(label) == 1 and label[0]}


def _of_records(columns: dict[str, str], key: str, arrays: Arrays, rig: Rig | None, where: str) -> ArrayMap:
    wanted = [*columns] if rig is None else [channel.name for channel in rig.channels]
    found = {name: columns.get(name) or usual_name(arrays, name) for name in wanted}
    missing = [name for name, array in found.items() if not array]
    if missing:
        raise DataError(
            f"{key} names the columns {', '.join(columns)}; channel {', '.join(missing)} of the rig is none of them",
            where=where,
            remedy="name the channels of the rig as the file does, or say --variable CHANNEL=NAME:COLUMN for each",
        )
    force = next((n for n in wanted if n.lower() in FORCE_NAMES), "") if rig is None else rig.force and rig.force.name
    step = arrays.get(usual_name(arrays, STEP) or "")
    rate = 1 / float(np.ravel(step)[0]) if step is not None and step.size == 1 and np.ravel(step)[0] > 0 else ""
    return ArrayMap(
        time=usual_name(arrays, TIME) or "",
        rate_hz=usual_name(arrays, RATE) or rate,
        force=(force and found[force]) or "",
        responses={name: array for name, array in found.items() if name != force and array},
    )


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
