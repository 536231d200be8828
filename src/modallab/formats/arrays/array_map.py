"""Which array of a file is what, as its owner says it in a small YAML file."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Self, cast

import numpy as np
import yaml
from numpy.typing import NDArray
from pydantic import Field, PositiveInt, ValidationError, model_validator

from modallab.core.errors import DataError, FormatError
from modallab.core.frozen import Frozen

Axis = Literal["outputs", "inputs", "lines", "samples", "records"]
EXAMPLE = (
    "{frf: data.H, axes: [outputs, inputs, lines], frequency: data.f, unit: m/s^2/N, outputs: [1, 2, 3], inputs: [3]}"
    " for FRFs, {time: t, force: F, responses: acc, axes: [samples, outputs], response_unit: g} for records"
)
REMEDY = f"say which is which in a file, --map map.yaml, such as {EXAMPLE}"


class ArrayMap(Frozen):
    """What the arrays of a file are. Fields of a structure are named structure.field.

    Attributes:
        frf: array of the FRFs.
        frequency: array of their lines.
        frequency_unit: of the lines.
        coherence: array of their coherences, with the axes of the FRFs.
        unit: of the FRFs, such as m/s^2/N; "" for that of the rig's channels, or SI inertance if there is no rig.
        time: array of times in s.
        rate_hz: sampling rate in Hz, or the variable that holds it.
        force: array of the force; "" if none was measured.
        force_unit: "" for that of the rig's channel.
        responses: array of all responses, or for each channel its array, perhaps with :column from 1.
        response_unit: "" for that of the rig's channels.
        axes: what each axis of the FRFs or of the array of all responses counts, in their order.
        outputs: for each response in the order of the array its channel's name, or the number of its point.
        inputs: number of the point of each force.
    """

    frf: str = ""
    frequency: str = ""
    frequency_unit: Literal["Hz", "kHz", "rad/s"] = "Hz"
    coherence: str = ""
    unit: str = ""
    time: str = ""
    rate_hz: str | Annotated[float, Field(gt=0, allow_inf_nan=False)] = ""
    force: str = ""
    force_unit: str = ""
    responses: str | dict[str, str] = ""
    response_unit: str = ""
    axes: tuple[Axis, ...] = ()
    outputs: tuple[PositiveInt | str, ...] = ()
    inputs: tuple[PositiveInt, ...] = ()

    @model_validator(mode="after")
    def _check(self) -> Self:
        if bool(self.frf) == bool(self.responses):
            raise ValueError("names neither or both of frf and responses")
        if self.frf and not self.frequency:
            raise ValueError("names no frequency")
        known = {"outputs", "inputs", "lines"} if self.frf else {"outputs", "samples", "records"}
        if set(self.axes) - known or len(set(self.axes)) < len(self.axes):
            raise ValueError(f"axes are {', '.join(self.axes)}; each of {', '.join(sorted(known))} may stand once")
        return self


def read_map(path: Path) -> ArrayMap:
    """The map in a YAML file.

    Raises:
        FormatError: it cannot be read, or says what no map says.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise FormatError(f"cannot be read: {error.strerror or error}", where=str(path), remedy=REMEDY) from error
    except UnicodeDecodeError as error:
        raise FormatError(f"is no YAML: {error}", where=str(path), remedy=REMEDY) from error
    return parse_map(text, str(path))


def parse_map(text: str, where: str) -> ArrayMap:
    """The map in the text of such a file.

    Raises:
        FormatError: it is no YAML, or says what no map says.
    """
    try:
        content: object = yaml.safe_load(text)
    except yaml.YAMLError as error:
        first = str(error).partition("\n")[0]
        raise FormatError(f"is no YAML: {first}", where=where, remedy=REMEDY) from error
    return map_of(content, where)


def map_of(content: object, where: str) -> ArrayMap:
    """The map with this content.

    Raises:
        FormatError: it says what no map says; names every field that is wrong.
    """
    try:
        return ArrayMap.model_validate(content)
    except ValidationError as error:
        message = "; ".join(_message(cast("Any", e)) for e in error.errors())
        raise FormatError(message, where=where, remedy=REMEDY) from error


def array_named(arrays: Mapping[str, NDArray[Any]], key: str, where: str) -> NDArray[Any]:
    """The array of a name, or one of its columns if a number follows a colon.

    Raises:
        DataError: there is no such array or column; lists those there are.
    """
    if key in arrays:
        return arrays[key]
    name, _, column = key.rpartition(":")
    if name not in arrays:
        raise DataError(f"has no array {key!r}", where=where, remedy=f"name one of {listed(arrays)}")
    values = arrays[name]
    if values.ndim != 2 or not column.isdigit() or not 1 <= int(column) <= min(values.shape):
        raise DataError(
            f"{key!r} names no column of an array {values.shape}", where=where, remedy="count its columns from 1"
        )
    rows = values if values.shape[0] < values.shape[1] else values.T
    return rows[int(column) - 1]


def in_order(
    values: NDArray[Any], axes: Sequence[Axis], wanted: Sequence[Axis], sizes: Mapping[str, int], where: str
) -> NDArray[Any]:
    """An array with its axes in the order that is wanted.

    Args:
        values: MATLAB drops axes of one element, so that such may be missing.
        axes: what each axis counts.
        wanted: the same in the order asked for; one that `axes` does not name has one element.
        sizes: of the axes whose size is known.
        where: file and array, for the message.

    Raises:
        DataError: the array has other axes, or of another size.
    """
    kept = [a for a in axes if values.ndim >= len(axes) or sizes.get(a, 0) != 1]
    wrong = [f"{sizes[a]} {a}" for a, n in zip(kept, values.shape, strict=False) if sizes.get(a, n) != n]
    if len(kept) != values.ndim or wrong:
        raise DataError(
            f"the array has shape {values.shape}, and its axes are to be {', '.join(axes)}"
            + (f", with {' and '.join(wrong)}" if wrong else ""),
            where=where,
            remedy="mend axes, outputs or inputs in the map",
        )
    turned = np.transpose(values, [kept.index(a) for a in wanted if a in kept])
    return np.ascontiguousarray(turned.reshape([values.shape[kept.index(a)] if a in kept else 1 for a in wanted]))


def without_singleton_axes(values: NDArray[Any]) -> NDArray[Any]:
    """An array without axes of one element; those of complex FRFs stay: they say which axis counts what."""
    return values if values.ndim > 2 and np.iscomplexobj(values) else np.squeeze(values)


def listed(arrays: Mapping[str, NDArray[Any]]) -> str:
    """The arrays with their shapes, for a message."""
    return ", ".join(f"{name} {'x'.join(map(str, a.shape)) or '1'}" for name, a in arrays.items()) or "no arrays"


def _message(error: dict[str, Any]) -> str:
    place, kind = ".".join(str(part) for part in error["loc"]), error["type"]
    if kind == "extra_forbidden":
        return f"{place} is no field of a map; there are {', '.join(ArrayMap.model_fields)}"
    message = str(error["msg"]).removeprefix("Value error, ")
    return f"{place}: {message}" if place else message
