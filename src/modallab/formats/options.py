"""What a file without such facts is to be taken for."""

import math
from dataclasses import dataclass

from modallab.core.axis_checks import check_rate
from modallab.core.errors import DataError
from modallab.core.rig import Channel, Rig
from modallab.core.units import Test
from modallab.formats.arrays.array_map import ArrayMap

COUNTED_HZ = 1.0
"""The rate of an abscissa that counts samples, as programs write it that know no rate (LabVIEW: `Delta_X` 1)."""
_AGREE = 1e-3
"""Relative difference allowed between a rate that was given and that of the times."""


@dataclass(frozen=True, slots=True)
class ImportOptions:
    """What the user says about recordings that do not say it themselves.

    Attributes:
        test: which test they belong to.
        rate_hz: sampling rate of recordings without times.
        drive_point: point of the hit or of the shaker.
        volts: numbers without a unit are volts, to be scaled by the sensitivities of the rig; otherwise they are in
            each channel's own unit.
        frequency_hz: what the generator was set to in a sine test.
        window_s: time constant tau of the exponential window exp(-t / tau) that FRFs were made with.
        variables: (channel, name of its array, perhaps with :column from 1) where files call their arrays otherwise;
            instead of a channel also time, rate, frequency, frf, coherence, or all for all channels.
        array_map: what the arrays of a MATLAB file are; instead of `variables`.
        level: name of the level that the structure was driven at.
        channels: names of the channels to take for a drafted rig, or of a rig; () for all.
        ignore: names of channels to leave out.
        group: name of the group of a TDMS file to read; "" for all that hold the channels of the rig.
        columns: name and unit of each column of a table, as "time,force:N,a01:m/s^2", instead of its header; a column
            without a name is left out. "" where the header says it.
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

    def takes(self, name: str) -> bool:
        """Whether a channel of this name is wanted."""
        low = name.lower()
        return low not in map(str.lower, self.ignore) and (not self.channels or low in map(str.lower, self.channels))

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
