"""What installed packages declare for modallab: drivers, simulators, effects."""

import sys
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points


def installed_entry_points(group: str) -> tuple[EntryPoint, ...]:
    """The entry points of a group, such as `modallab.backends`.

    The files of all installed packages are read once for each path that is searched: to read them takes longer than to
    open a simulated bench.
    """
    return _by_group(tuple(sys.path)).get(group, ())


@lru_cache(maxsize=4)
def _by_group(path: tuple[str, ...]) -> dict[str, tuple[EntryPoint, ...]]:
    found = entry_points()
    return {group: tuple(found.select(group=group)) for group in found.groups}
