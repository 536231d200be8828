"""What the user can say of recordings that do not say it themselves: one description for all who ask.

The command line makes its options of it, `ml.load` its arguments, the REST service its parameters, and the page its
form of these. It imports nothing heavy.
"""

from dataclasses import dataclass
from typing import Literal

Kind = Literal["text", "number", "count", "switch", "test", "map"]


@dataclass(frozen=True, slots=True)
class ImportOption:
    """An option of an import.

    Attributes:
        about: what it says, in a sentence without a subject.
        kind: of its value, or of each of several: a number is above 0, a count from 1 on.
        called: by the command line and the service, where the field of `ImportOptions` is called otherwise.
        metavar: what stands for the value in the help of the command.
        several: whether it takes several values.
        each: whether it takes one value for each file, or one for all.
        frfs: whether it is of FRFs only, which the service does not keep.
    """

    about: str
    kind: Kind = "text"
    called: str = ""
    metavar: str = "NAME"
    several: bool = False
    each: bool = False
    frfs: bool = False


ASKED: dict[str, ImportOption] = {
    "test": ImportOption("kind of test (default: impact; random if no force was measured)", "test"),
    "rate_hz": ImportOption("sampling rate, for files without times", "number", "rate", "HZ"),
    "drive_point": ImportOption("point of the hit or of the shaker", "count", metavar="N"),
    "frequency_hz": ImportOption(
        "frequency of the sine in each file, or in all files", "number", "frequency", "HZ", each=True
    ),
    "window_s": ImportOption("time constant of the exponential window of the FRFs", "number", "window", "S", frfs=True),
    "variables": ImportOption(
        "name of a channel in the file (NAME:2 the second column of an array), or of time, rate, frequency, frf, "
        "coherence, all",
        called="variable",
        metavar="CHANNEL=NAME",
        several=True,
    ),
    "columns": ImportOption(
        "columns of a table without a header, or to replace it: time,force:N,a01:m/s^2; an empty name is left out",
        metavar="NAME:UNIT,...",
    ),
    "channels": ImportOption("channels to import (default: all)", several=True),
    "ignore": ImportOption("channels to leave out", several=True),
    "level": ImportOption("drive level of each file, or of all", each=True),
    "set_up": ImportOption("name of the files' set-up of sensors"),
    "array_map": ImportOption("map of the variables of a MATLAB file", "map", "map", "MAP.yaml"),
    "group": ImportOption("group of a TDMS file to read (default: all that fit)"),
    "volts": ImportOption("take numbers without a unit as volts", "switch"),
}
"""By field of `ImportOptions`."""
