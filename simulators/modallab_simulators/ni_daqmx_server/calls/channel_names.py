"""Lists and ranges of channels, as they are written: `Dev1/ai0:3, Dev1/ai7`."""

import re

from modallab_simulators.ni_daqmx_server.status import StatusError

_RANGE = re.compile(r"(?P<stem>.*?)(?P<first>\d+):(?:.*?)(?P<last>\d+)")
BAD_RANGE = -200498


def split(names: str) -> list[str]:
    """Each channel of a list by itself.

    Raises:
        StatusError: a range that cannot be read.
    """
    found: list[str] = []
    for part in (p.strip().removeprefix("/") for p in names.split(",")):
        if ":" not in part:
            found += [part] if part else []
            continue
        match = _RANGE.fullmatch(part)
        if match is None:
            raise StatusError(BAD_RANGE, f"Channels: {part}")
        first, last = int(match["first"]), int(match["last"])
        step = 1 if last >= first else -1
        found += [f"{match['stem']}{n}" for n in range(first, last + step, step)]
    return found


def assigned(wanted: str, physical: list[str]) -> list[str]:
    """The task's names of physical channels: those that were asked for, or their own."""
    if not wanted:
        return physical
    names = split(wanted)
    if len(names) == len(physical):
        return names
    return [f"{wanted}{n}" for n in range(len(physical))]
