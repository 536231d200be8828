"""Records or FRFs from arrays, as a map says what they are."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.array_checks import check_rate, check_time
from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError
from modallab.core.frf import Frf, FrfQuantity
from modallab.core.rig import Channel, Rig
from modallab.formats.arrays.array_map import ArrayMap, Axis, array_named, in_order
from modallab.formats.arrays.channel_times import channel_times
from modallab.formats.block_facts import facts_or_options
from modallab.formats.frf_file import OF_THE_RIG, assumed_factor, rising, share_of_one, turned
from modallab.formats.options import ImportOptions
from modallab.formats.unit_text import frf_unit, normal_unit

Arrays = Mapping[str, NDArray[Any]]

_TO_HZ = {"Hz": 1.0, "kHz": 1e3, "rad/s": 1 / (2 * np.pi)}
_FRF: tuple[Axis, ...] = ("outputs", "inputs", "lines")
_RECORDS: tuple[Axis, ...] = ("records", "outputs", "samples")


def campaign_of_map(
    arrays: Arrays, array_map: ArrayMap, name: str, rig: Rig, options: ImportOptions, where: str
) -> Campaign:
    """The records, or one matrix of FRFs.

    Raises:
        DataError: arrays that are missing, or of other shapes, units or channels than the map and the rig say.
    """
    if array_map.frf:
        said = {} if array_map.unit else {"notes": f"{name}: {OF_THE_RIG}"}
        return Campaign(rig, (), (_frf(arrays, array_map, rig, options, where),), said, where)
    return Campaign(rig, tuple(_blocks(arrays, array_map, name, rig, options, where)), source=where)


def channels_of(array_map: ArrayMap, rig: Rig, where: str) -> tuple[Channel, ...]:
    """The rig's channel of each response of the map, in the map's order; all responses if it names none.

    Raises:
        DataError: one is not on the rig, or several are at one point.
    """
    found: list[Channel] = []
    for one in array_map.outputs:
        fitting = [c for c in rig.responses if one in (c.name, c.point)]
        if len(fitting) != 1:
            raise DataError(
                f"output {one!r} of the map is {'several channels' if fitting else 'no channel'} of the rig",
                where=where,
                remedy=f"name channels of it: {', '.join(c.name for c in rig.responses)}",
            )
        found += fitting
    return tuple(found) or rig.responses


def _frf(arrays: Arrays, array_map: ArrayMap, rig: Rig, options: ImportOptions, where: str) -> Frf:
    lines = (
        np.ravel(array_named(arrays, array_map.frequency, where)).astype(np.float64) * _TO_HZ[array_map.frequency_unit]
    )
    outputs = channels_of(array_map, rig, where)
    sizes = {"lines": lines.size, "outputs": len(outputs), "inputs": len(array_map.inputs) or 1}
    held = array_named(arrays, array_map.frf, where)
    if not array_map.inputs and "inputs" in array_map.axes:
        sizes["inputs"] = held.shape[array_map.axes.index("inputs")] if held.ndim == len(array_map.axes) else 1
    axes = array_map.axes or _guessed(held, sizes, _FRF, where)
    values = in_order(held, axes, _FRF, sizes, f"{where}, {array_map.frf}")
    quantity, factors = _units(array_map, outputs, rig, where)
    names = tuple(c.name for c in outputs)
    coherence = None
    if array_map.coherence:
        found = in_order(array_named(arrays, array_map.coherence, where), axes, _FRF, sizes, f"{where}, coherence")
        coherence = share_of_one(found.astype(np.float64), where)
    lines, values, coherence = rising(lines, values, coherence)
    inputs = array_map.inputs or ((options.drive_point,) if values.shape[1] == 1 else (None,) * values.shape[1])
    return Frf(
        frequency_hz=lines,
        values=values.astype(np.complex128) * (factors * [turned(c, rig) for c in outputs])[:, None, None],
        quantity=quantity,
        outputs=names,
        output_points=tuple(c.point for c in outputs),
        input_points=inputs,
        coherence=coherence,
    )


def _units(
    array_map: ArrayMap, outputs: tuple[Channel, ...], rig: Rig, where: str
) -> tuple[FrfQuantity, NDArray[np.float64]]:
    assumed = [assumed_factor(c, rig, where) for c in outputs]
    if len({quantity for quantity, _ in assumed}) > 1:
        raise DataError(
            "the outputs are of several quantities", where=where, remedy="name those of one quantity as outputs"
        )
    if not array_map.unit:
        return assumed[0][0], np.array([factor for _, factor in assumed])
    found = frf_unit(normal_unit(array_map.unit), "")
    if found is None:
        raise DataError(
            f"unit {array_map.unit!r} is none of an FRF of motion over force",
            where=where,
            remedy="write it in the map as m/s^2/N, m/s/N or m/N",
        )
    return found[0], np.full(len(outputs), found[1])


def _guessed(values: NDArray[Any], sizes: Mapping[str, int], wanted: tuple[Axis, ...], where: str) -> tuple[Axis, ...]:
    """The axes of an array, if their sizes leave no choice."""
    places: list[Axis] = []
    for n in values.shape:
        fitting = _fitting(n, values.ndim, sizes, wanted, places)
        if len(fitting) == 1:
            places.append(fitting[0])
    if len(places) != values.ndim:
        raise DataError(
            f"which axis of an array {values.shape} counts what is not certain",
            where=where,
            remedy=f"write axes into the map, such as [{', '.join(wanted)}]",
        )
    return tuple(places)


def _fitting(n: int, axes: int, sizes: Mapping[str, int], wanted: tuple[Axis, ...], taken: list[Axis]) -> list[Axis]:
    """What an axis of n elements may count; one of a single element may be missing."""
    found: list[Axis] = []
    for a in wanted:
        if sizes.get(a) == n and a not in taken and (n != 1 or axes == len(wanted)):
            found.append(a)  # noqa: PERF401
    return found


def _blocks(
    arrays: Arrays, array_map: ArrayMap, name: str, rig: Rig, options: ImportOptions, where: str
) -> Iterator[Block]:
    responses = _responses(arrays, array_map, rig, where)
    records, _, n = responses.shape
    _check_together(arrays, array_map, where)
    force = None
    if rig.force is not None:
        if not array_map.force:
            raise DataError("the map names no force, and the rig has one", where=where, remedy="name its array")
        values = np.asarray(array_named(arrays, array_map.force, where), np.float64)
        axes = _guessed(
            values, {"records": records, "samples": n}, ("records", "samples"), f"{where}, {array_map.force}"
        )
        force = in_order(values, axes, ("records", "samples"), {"records": records, "samples": n}, where)
    place = {c.name: k for k, c in enumerate(rig.responses)}
    rate = _rate(arrays, array_map, options, n, where)
    force_unit, unit = normal_unit(array_map.force_unit), normal_unit(array_map.response_unit)
    units = [force_unit if c.quantity == "force" else unit for c in rig.channels]
    for k in range(records):
        rows = [force[k] if c.quantity == "force" and force is not None else responses[k, place[c.name]]
                for c in rig.channels]  # fmt: skip
        samples = np.ascontiguousarray(np.stack(rows), np.float64)
        facts = facts_or_options(None, name if records == 1 else f"{name}_{k + 1}", rate, options)
        yield replace(facts, drive_point=(array_map.inputs or (options.drive_point,))[0]).block(
            samples, units, rig, order=k
        )


def _responses(arrays: Arrays, array_map: ArrayMap, rig: Rig, where: str) -> NDArray[np.float64]:
    """(records, responses in rig order, samples)."""
    if isinstance(array_map.responses, dict):
        names = [c.name for c in rig.responses]
        missing = [name for name in names if name not in array_map.responses]
        if missing:
            raise DataError(f"the map names no array for {', '.join(missing)}", where=where, remedy="add it")
        each = [np.ravel(array_named(arrays, array_map.responses[name], where)) for name in names]
        if len({row.size for row in each}) > 1:
            raise DataError("the responses differ in length", where=where, remedy="export them together")
        return np.stack(each).astype(np.float64)[None]
    values, outputs = array_named(arrays, array_map.responses, where), channels_of(array_map, rig, where)
    sizes = {"outputs": len(outputs)} | ({} if "records" in array_map.axes else {"records": 1})
    axes = array_map.axes or _by_outputs(values, len(outputs))
    turned = in_order(values, axes, _RECORDS, sizes, f"{where}, {array_map.responses}").astype(np.float64)
    order = [outputs.index(c) if c in outputs else -1 for c in rig.responses]
    if -1 in order:
        raise DataError("the map does not name all responses of the rig", where=where, remedy="add them to outputs")
    return turned[:, order]


def _check_together(arrays: Arrays, array_map: ArrayMap, where: str) -> None:
    """Reject arrays whose own times, beside them in the file, begin apart: the map has one time for all."""
    each = list(array_map.responses.values()) if isinstance(array_map.responses, dict) else [array_map.responses]
    names = [name for name in (array_map.force, *each) if name in arrays]
    starts = {n: channel_times(arrays, n, max(arrays[n].shape), where).start for n in names if arrays[n].ndim == 1}
    known = {name: float(start.at_s) for name, start in starts.items() if start is not None}
    if len(set(known.values())) > 1:
        raise DataError(
            "begins at different times: " + ", ".join(f"{name} at {at:g} s" for name, at in known.items()),
            where=where,
            remedy="name the channels by --variable instead of a map: they are then brought onto common times",
        )


def _by_outputs(values: NDArray[Any], outputs: int) -> tuple[Axis, ...]:
    if values.ndim == 1:
        return ("samples",)
    return ("outputs", "samples") if values.shape[0] == outputs else ("samples", "outputs")


def _rate(arrays: Arrays, array_map: ArrayMap, options: ImportOptions, n: int, where: str) -> float:
    if array_map.time:
        times = np.ravel(array_named(arrays, array_map.time, where))
        if times.size != n:
            raise DataError(
                f"has {times.size} times and {n} samples", where=where, remedy="name the record's own times"
            )
        return options.of_times(check_time(times, f"{where}, times"), "", where)
    if isinstance(array_map.rate_hz, str) and array_map.rate_hz:
        own = check_rate(float(np.ravel(array_named(arrays, array_map.rate_hz, where))[0]), where)
    elif isinstance(array_map.rate_hz, float):
        own = check_rate(array_map.rate_hz, where)
    elif options.rate_hz is not None:
        return check_rate(options.rate_hz, where)
    else:
        raise DataError("says neither times nor a rate", where=where, remedy="write time or rate_hz into the map")
    return options.agreed(own, where)
