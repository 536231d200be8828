"""A record or FRFs from arrays with names."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_rate, check_time
from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.formats.arrays.array_map import ArrayMap, Axis, array_named, listed
from modallab.formats.arrays.channel_times import channel_times
from modallab.formats.arrays.mapped import campaign_of_map
from modallab.formats.block_facts import facts_or_options
from modallab.formats.options import ImportOptions, units_of
from modallab.formats.starts import cut_to_common_time, one_rate, rate_note
from modallab.formats.time_names import RATES, STEPS, plain_name
from modallab.formats.unit_text import normal_unit, unit_in_name, without_unit

Arrays = Mapping[str, NDArray[Any]]
Texts = Mapping[str, tuple[str, ...]]
"""Variables of text, each with a string for each of its rows or cells."""

TIME, RATE, STEP, FREQUENCY, FRF, COHERENCE, ALL = "time", "rate", "step", "frequency", "frf", "coherence", "all"
_USUAL = {
    TIME: ("time", "t", "timestamps"),
    RATE: RATES,
    STEP: STEPS,
    FREQUENCY: ("frequency", "freq", "f", "frequency_hz"),
    FRF: ("frf", "h", "frfs"),
    COHERENCE: ("coherence", "coh"),
}
_FRF_AXES: tuple[tuple[Axis, ...], ...] = (
    ("lines",),
    ("outputs", "lines"),
    ("lines", "outputs"),
    ("outputs", "inputs", "lines"),
    ("lines", "outputs", "inputs"),
    ("inputs", "outputs", "lines"),
    ("lines", "inputs", "outputs"),
    ("outputs", "lines", "inputs"),
    ("inputs", "lines", "outputs"),
)
"""Ways round that FRFs may stand; of those that fit the first is taken."""
_SAMPLES = ("data", "values", "samples", "signal", "y", "y_values.values")
"""Fields of a channel's own structure that hold its samples."""


_UNITS = ("unit", "units", "unit_string", "unit_str", "unit_label", "y_unit")
"""Fields of it that hold their unit."""


def campaign_of_arrays(
    arrays: Arrays, name: str, rig: Rig, options: ImportOptions, where: str, texts: Texts | None = None
) -> Campaign:
    """One record, or one matrix of FRFs.

    An array belongs to the channel of its name, or to the one that `options.variables` says. `frequency` and `frf`
    hold FRFs; `time` or `rate` belong to records, whose channels may also stand in one array, `all`, in rig order.
    `texts` may hold the unit of a channel, in the structure of its samples.

    Raises:
        DataError: channels, times or lines that are missing or do not fit.
    """
    array_map = _map_of_frf(arrays, rig, options, where)
    if array_map is not None:
        return campaign_of_map(arrays, array_map, name, rig, options, where)
    found = {key: _find(arrays, key, options, where) for key in (TIME, RATE, STEP)}
    samples, rate, note = _record(arrays, found, rig, options, where)
    units = _units(rig, arrays, texts or {}, options, where)
    _require_scales(arrays, units, rig, options, where)
    block = facts_or_options(None, name, rate, options).block(samples, units, rig)
    return Campaign(rig, (block,), provenance={"notes": f"{name}: {note}"} if note else {}, source=where)


def owner_of(key: str) -> str:
    """The name of the structure that holds a channel's samples; that of its array, if it has none of its own."""
    return next((key.removesuffix(f".{name}") for name in reversed(_SAMPLES) if key.endswith(f".{name}")), key)


def _units(rig: Rig, arrays: Arrays, texts: Texts, options: ImportOptions, where: str) -> tuple[str, ...]:
    owned = {f"{owner_of(key)}{mark}{name}".lower() for key in arrays for mark in "._" for name in _UNITS}
    apart = {key: rows for key, rows in texts.items() if key.lower() not in owned}
    elsewhere = [row for key, rows in apart.items() if "unit" in key.rpartition(".")[2].lower() for row in rows]
    beside = [unit_beside(texts, _key(arrays, c.name, options)) for c in rig.channels]
    return units_of(rig.channels, beside, elsewhere, where)


def _require_scales(arrays: Arrays, units: tuple[str, ...], rig: Rig, options: ImportOptions, where: str) -> None:
    """Reject whole numbers without a unit: they are counts of a converter, and what one of them is nothing says."""
    keys = {c.name: _key(arrays, c.name, options) for c, unit in zip(rig.channels, units, strict=True) if not unit}
    kinds = {n: array_named(arrays, key, where).dtype for n, key in keys.items() if key and not options.volts}
    whole = [f"{name} ({kind})" for name, kind in kinds.items() if kind.kind in "iu"]
    if whole:
        raise DataError(
            f"holds whole numbers without a unit, whose scale is not known: {', '.join(whole)}",
            where=where,
            remedy="save them in volts or in the channels' units as floating-point numbers, or with a unit beside them",
        )


def unit_beside(texts: Texts, key: str | None) -> str:
    """The unit that the file gives to the samples of this name, or of its column of this number; "" without one."""
    array, _, column = (key or "").rpartition(":")
    array, place = (array, int(column)) if array and column.isdigit() else (key or "", 0)
    owner, named = owner_of(array).lower(), {name.lower(): rows for name, rows in texts.items()}
    wanted = [*(f"{owner}{mark}{name}" for mark in "._" for name in _UNITS), f"{owner}.y_values.quantity.label"]
    said = [
        rows[0] if len(rows) == 1 else "".join(rows[place - 1 : place]) for one in wanted if (rows := named.get(one))
    ]
    return normal_unit(next(filter(None, said), "")) or unit_in_name(array.rpartition(".")[2])


def find_usual(arrays: Arrays, key: str) -> NDArray[Any] | None:
    """The array that is usually called so, or the only field of a structure that is; None if there is none."""
    name = usual_name(arrays, key)
    return None if name is None else arrays[name]


def usual_name(arrays: Arrays, key: str) -> str | None:
    """The name of the array that is usually called so."""
    usual = _USUAL.get(key, (key.lower(),))
    for last in (False, True):
        bare = [without_unit(name.rpartition(".")[2] if last else name) for name in arrays]
        names = [plain_name(name) if key in (RATE, STEP) else name.lower() for name in bare]
        for name in usual:
            if names.count(name) == 1:
                return list(arrays)[names.index(name)]
    return None


def _find(arrays: Arrays, key: str, options: ImportOptions, where: str) -> NDArray[Any] | None:
    """The array that a key stands for; None if there is none."""
    name = dict(options.variables).get(key)
    if name is not None:
        return array_named(arrays, name, where)
    if key.rpartition(":")[0] in arrays:
        return array_named(arrays, key, where)
    return find_usual(arrays, key)


def _record(
    arrays: Arrays, found: Mapping[str, NDArray[Any] | None], rig: Rig, options: ImportOptions, where: str
) -> tuple[NDArray[np.float64], float, str]:
    """Samples (channels, n), their rate, and a note where the channels begin at different times."""
    names = [channel.name for channel in rig.channels]
    keys = {name: _key(arrays, name, options) for name in names}
    missing = [name for name, key in keys.items() if key is None]
    if missing:
        samples = _together(arrays, names, missing, options, where)
        return samples, _rate(found, options, samples.shape[1], where), ""
    rows = [_row(array_named(arrays, key, where), key, where) for key in keys.values() if key is not None]
    own = [channel_times(arrays, key or "", row.size, where) for key, row in zip(keys.values(), rows, strict=True)]
    said = {name: one.rate_hz for name, one in zip(names, own, strict=True)}
    rate = options.agreed(one_rate(said, where) or _rate(found, options, rows[0].size, where), where)
    starts = [one.start for one in own]
    if any(starts) and None in starts:
        without = ", ".join(n for n, s in zip(names, starts, strict=True) if s is None)
        found_ = f"says when other channels begin, and nothing of {without}"
        raise DataError(found_, where=where, remedy="give every channel its start, or none")
    samples, note = cut_to_common_time([_real(row, where) for row in rows], starts, rate, names, where)
    return samples, rate, "; ".join(filter(None, (rate_note(said), note)))


def _row(values: NDArray[Any], key: str, where: str) -> NDArray[Any]:
    if max(values.shape, default=1) < values.size:
        raise DataError(
            f"{key} is an array of {'x'.join(map(str, values.shape))}, and a channel is one row or column",
            where=where,
            remedy=f"name the column, as --variable CHANNEL={key}:2; or say by --map map.yaml what its axes are",
        )
    return np.ravel(values)


def _key(arrays: Arrays, channel: str, options: ImportOptions) -> str | None:
    """The name of a channel's array, perhaps with a column; None if there is none."""
    name = dict(options.variables).get(channel)
    if name is not None or channel.rpartition(":")[0] in arrays:
        return name or channel
    low, low_names = channel.lower(), {name: without_unit(name).lower() for name in arrays}
    wanted = (low, *(f"{low}.{name}" for name in _SAMPLES))
    for within in (False, True):
        for one in wanted:
            fitting = [n for n, bare in low_names.items() if bare == one or (within and bare.endswith(f".{one}"))]
            if len(fitting) == 1:
                return fitting[0]
    return None


def _together(
    arrays: Arrays, names: list[str], missing: list[str], options: ImportOptions, where: str
) -> NDArray[np.float64]:
    """All channels from one array, the only one with as many rows or columns."""
    whole = _find(arrays, ALL, options, where)
    fitting = [a for a in arrays.values() if a.ndim == 2 and len(names) == min(a.shape) < max(a.shape)]
    if whole is None and len(fitting) == 1:
        (whole,) = fitting
    if whole is None or whole.ndim != 2 or len(names) not in whole.shape:
        raise DataError(
            f"no array for channel {', '.join(missing)}; there are {listed(arrays)}",
            where=where,
            remedy="say which is which by --map map.yaml, by --variable CHANNEL=NAME or CHANNEL=NAME:COLUMN, or all of "
            "them by all=NAME",
        )
    return _real(whole if whole.shape[0] == len(names) else whole.T, where)


def _real(values: NDArray[Any], where: str) -> NDArray[np.float64]:
    if values.dtype.kind not in "fiu":
        raise DataError(f"holds values of type {values.dtype}", where=where, remedy="give records as real numbers")
    return np.ascontiguousarray(values, np.float64)


def _rate(found: Mapping[str, NDArray[Any] | None], options: ImportOptions, n: int, where: str) -> float:
    times, rate, step = found[TIME], found[RATE], found[STEP]
    if rate is None and step is not None and step.size == 1 and step.dtype.kind in "fiu":
        rate = 1 / np.where(step > 0, step, np.inf)
    if times is not None and times.size == n:
        own = check_time(np.ravel(times), f"{where}, times")
        beside = rate if rate is not None and rate.size == 1 and TIME not in dict(options.variables) else own
        return options.of_times(own, "", where, float(np.ravel(beside)[0]))
    if rate is not None and rate.size == 1:
        own = check_rate(float(np.ravel(rate)[0]), where)
    elif options.rate_hz is not None:
        return check_rate(options.rate_hz, where)
    else:
        raise DataError(
            "says neither times nor a rate", where=where, remedy="give the rate with --rate, or --variable time=NAME"
        )
    return options.agreed(own, where)


def _map_of_frf(arrays: Arrays, rig: Rig, options: ImportOptions, where: str) -> ArrayMap | None:
    """What a file of FRFs holds, by the usual names or those of the options; None for a file of records.

    Raises:
        DataError: FRFs of other sizes than the rig's responses at these lines.
    """
    named = dict(options.variables)
    frf, frequency, coherence = (named.get(key) or usual_name(arrays, key) or "" for key in (FRF, FREQUENCY, COHERENCE))
    if not frf or not frequency:
        return None
    shape, outputs = array_named(arrays, frf, where).shape, len(rig.responses)
    sizes = {"lines": array_named(arrays, frequency, where).size, "outputs": outputs}
    axes = next((axes for axes in _FRF_AXES if _fits(axes, shape, sizes)), None)
    if axes is None:
        raise DataError(
            f"FRFs of shape {shape} are none of {outputs} outputs at {sizes['lines']} lines",
            where=where,
            remedy="give (outputs, inputs, lines) or (lines, outputs, inputs), with the rig's responses as outputs",
        )
    return ArrayMap(frf=frf, frequency=frequency, coherence=coherence, axes=axes)


def _fits(axes: tuple[Axis, ...], shape: tuple[int, ...], sizes: Mapping[str, int]) -> bool:
    """Whether an array may have these axes; one of a single element may be missing."""
    alike = len(axes) == len(shape) and all(sizes.get(axis, n) == n for axis, n in zip(axes, shape, strict=True))
    return alike and all(axis in axes or n == 1 for axis, n in sizes.items())
