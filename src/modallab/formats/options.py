"""What a file without such facts is to be taken for."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from modallab.core.axis_checks import check_rate
from modallab.core.errors import DataError
from modallab.core.rig import Channel, Rig
from modallab.core.units import Test
from modallab.formats.arrays.array_map import ArrayMap
from modallab.formats.asked import ASKED
from modallab.formats.unit_text import normal_unit, quantity_of, without_unit

COUNTED_HZ = 1.0
"""The rate of an abscissa that counts samples, as programs write it that know no rate (LabVIEW: `Delta_X` 1)."""
_RATES_HZ, _FASTEST_HZ = (1.0, 50.0), 1e7
"""No structure needs more; at less than 1 Hz none of its modes shows, and a hit is over within some 10 ms."""
_AGREE = 1e-3
"""Relative difference allowed between a rate that was given and that of the times."""


@dataclass(frozen=True, slots=True)
class ImportOptions:
    """What the user says about recordings of one file, by the fields of `ASKED`, which says what each is.

    Attributes:
        variables: (channel, name of its array, perhaps with :column from 1).
        array_map: instead of `variables`.
        channels: () for all.
        columns: a text of names and units; "" where the file's own header holds.
        group: "" for all groups that hold the channels of the rig.
    """

    test: Test = "impact"
    rate_hz: float | None = None
    drive_point: int | None = None
    volts: bool = False
    frequency_hz: float | None = None
    window_s: float | None = None
    variables: tuple[tuple[str, str], ...] = ()
    array_map: ArrayMap | None = None
    group: str = ""
    columns: str = ""
    level: str | None = None
    channels: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()
    set_up: str = ""

    def takes(self, name: str) -> bool:
        """Whether a channel of this name is wanted."""
        low = name.lower()
        return low not in map(str.lower, self.ignore) and (not self.channels or low in map(str.lower, self.channels))

    def channel_of(self, name: str) -> str:
        """The channel that the user says this name of the file is of; else the name itself, without its unit."""
        called = {said.lower(): channel for channel, said in self.variables}
        bare = without_unit(name)
        return called.get(name.lower()) or called.get(bare.lower(), bare)

    def unit(self, channel: Channel) -> str:
        """The unit of a channel's numbers where the file names none."""
        return "V" if self.volts else channel.unit

    def check(self, rig: Rig) -> None:
        """Reject what does not fit the rig.

        Raises:
            DataError: the drive point is not on the rig, a frequency of another test than a sine's, or a window that
                is none.
        """
        if self.frequency_hz is not None and (self.test != "sine" or not 0 < self.frequency_hz < math.inf):
            raise DataError(
                f"a frequency of {self.frequency_hz:g} Hz is given for recordings of the {self.test} test",
                remedy="give frequencies above 0 Hz, and only with --test sine",
            )
        if self.window_s is not None and not 0 < self.window_s < math.inf:
            raise DataError(
                f"a window that falls within {self.window_s:g} s is none",
                remedy="give its time constant: T / ln(1 / share) for one that falls to a share within T seconds",
            )
        known = [point.id for point in rig.points]
        if self.drive_point is not None and self.drive_point not in known:
            raise DataError(
                f"the drive point is {self.drive_point}; the rig has {', '.join(map(str, known)) or 'no points'}",
                remedy="name a point of the rig, or add the point to the rig file",
            )

    def of_times(self, found_hz: float, unit: str, where: str, beside_hz: float | None = None) -> float:
        """The rate in Hz that times say, as `agreed`; those without a unit are in s, if benches record at such rates.

        Args:
            found_hz: that the times say.
            unit: of the times, "" where none is written.
            where: file, for messages.
            beside_hz: that the file says beside them, None if it says none.

        Raises:
            DataError: no bench records so, `beside_hz` is another rate, or `agreed` rejects the rate.
        """
        if beside_hz and self.rate_hz is None and abs(found_hz - beside_hz) > _AGREE * found_hz:
            raise DataError(
                f"its times say {found_hz:g} Hz, and beside them stands a rate of {beside_hz:g} Hz",
                where=where,
                remedy="give the one that holds with --rate if the times have it; else correct the file",
            )
        lowest, highest = _RATES_HZ[self.test == "impact"], _FASTEST_HZ
        if not unit and self.rate_hz is None and not lowest <= found_hz <= highest:
            raise DataError(
                f"its times, taken as s, give {found_hz:.3g} Hz, at which no bench records this test",
                where=where,
                remedy="write the unit behind the name, as [ms], [ns] or [d]; give --rate for times that count samples",
            )
        return self.agreed(found_hz, where)

    def agreed(self, found_hz: float, where: str) -> float:
        """The rate of a recording in Hz: its own, or the one that was given if its abscissa only counts samples.

        Raises:
            DataError: the two contradict each other; names both.
        """
        if self.rate_hz is None or abs(found_hz - self.rate_hz) <= _AGREE * found_hz:
            return found_hz
        if found_hz == COUNTED_HZ:
            return check_rate(self.rate_hz, where)
        raise DataError(
            f"the file says {found_hz:g} Hz, --rate says {self.rate_hz:g} Hz",
            where=where,
            remedy="leave --rate out if the file is right; else correct its times or its step",
        )


def options_of(said: Mapping[str, Any], files: int) -> tuple[ImportOptions, ...]:
    """The options of each file.

    Args:
        said: by field of `ASKED`; what is None is not said. `variables` is a mapping, or texts CHANNEL=NAME.
        files: how many there are.

    Raises:
        DataError: there is no such option, it holds another kind of value, or not one for each file.
    """
    known = {name: value for name, value in said.items() if value is not None}
    for name in known:
        if name not in ASKED:
            near = get_close_matches(name, ASKED, n=1)
            remedy = f"did you mean {near[0]}?" if near else f"use one of {', '.join(ASKED)}"
            raise DataError(f"an import has no option {name!r}", remedy=remedy)
    if "variables" in known:
        known["variables"] = _pairs(known["variables"])
    for name in ("channels", "ignore"):
        known[name] = _listed(known.get(name, ()))
    each = {name: _of_each(name, known.pop(name), files) for name in tuple(known) if ASKED[name].each}
    return tuple(ImportOptions(**known, **{name: values[k] for name, values in each.items()}) for k in range(files))


def _listed(value: Any) -> tuple[Any, ...]:
    """Several values, or one alone."""
    return tuple(value) if isinstance(value, Sequence) and not isinstance(value, str) else (value,)


def _of_each(name: str, value: Any, files: int) -> tuple[Any, ...]:
    values = _listed(value)
    if len(values) not in (1, files):
        raise DataError(
            f"{ASKED[name].called or name}: {len(values)} values are given for {files} files",
            remedy="give one for each file, in the order of the files, or one for all",
        )
    return values if len(values) == files else values * files


def _pairs(given: Any) -> tuple[tuple[str, str], ...]:
    if isinstance(given, Mapping):
        return tuple((str(channel), str(name)) for channel, name in given.items())
    return tuple(one if isinstance(one, tuple) else _pair(one) for one in _listed(given))


def _pair(text: str) -> tuple[str, str]:
    channel, mark, name = text.partition("=")
    if not (mark and channel and name):
        raise DataError(f"{text!r} says no CHANNEL=NAME", remedy="write it as force=F or a1=data:2, without blanks")
    return channel, name


def units_of(
    channels: Sequence[Channel], beside: Sequence[str], elsewhere: Iterable[str], where: str
) -> tuple[str, ...]:
    """The unit of each channel: the one beside it, else the one that the file has for its quantity; else "".

    Args:
        channels: of the rig.
        beside: by channel, "" where the file has none.
        elsewhere: what else in the file may be a unit, such as a list that does not say whose each is.
        where: file, for messages.

    Raises:
        DataError: the file has several for one quantity, and does not say whose each is.
    """
    known = {normal_unit(text) for text in elsewhere}
    return tuple(b or _of_quantity(c, known, where) for b, c in zip(beside, channels, strict=True))


def _of_quantity(channel: Channel, known: Collection[str], where: str) -> str:
    fitting = sorted(unit for unit in known if quantity_of(unit) == channel.quantity)
    if len(fitting) > 1:
        raise DataError(
            f"has several units of {channel.quantity}, {' and '.join(fitting)}, and does not say whose each is",
            where=where,
            remedy=f"write the unit of {channel.name} beside its name",
        )
    return fitting[0] if fitting else ""
