"""What files call times, the rate of samples, their step and their start, in whichever spelling."""

import re

TIMES = ("time", "t", "times")
RATES = ("rate", "fs", "samplerate", "samplingrate", "samplefrequency", "samplingfrequency", "abtastrate")
STEPS = ("dt", "ts", "delta", "deltat", "deltax", "step", "timestep", "increment", "xincrement", "xaxisdelta")
STEPS += ("interval", "timeinterval", "tinterval", "sampleinterval", "samplinginterval")
STARTS = ("t0", "start", "starttime", "tstart", "startvalue", "x0")


def plain_name(name: str) -> str:
    """A name in small letters, without marks between its words, and without s or Hz behind it."""
    low = re.sub(r"[\W_]+", "_", name.lower()).strip("_")
    head, _, last = low.rpartition("_")
    return (head if last in ("s", "hz") and head else low).replace("_", "")
