"""Packages that only some work needs: each belongs to an extra of the distribution, and is named when it is missing."""

import sys
from functools import lru_cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from types import ModuleType

from modallab.core.errors import MissingPackageError

EXTRAS = {
    "cryptography": "tls",
    "distributed": "jobs",
    "mujoco": "mujoco",
    "opendaq": "opendaq",
    "pandas": "tables",
    "psycopg": "postgresql",
    "pyyeti": "nastran",
    "xarray": "tables",
}
"""Package -> the extra that brings it."""


def how_to_install(package: str) -> str:
    """How a package that is missing is installed."""
    extra = EXTRAS.get(package)
    return f"pip install 'modallab[{extra}]'" if extra else f"pip install {package}"


def require_package(package: str, purpose: str) -> None:
    """Look, without importing it, whether a package is there.

    Raises:
        MissingPackageError: it is not; the error says what it is needed for and how to install it.
    """
    if find_spec(package) is None:
        raise MissingPackageError(
            f"{purpose} needs the package {package}, which is not installed", remedy=how_to_install(package)
        )


def optional_package(package: str, purpose: str) -> ModuleType:
    """Import a package of an extra.

    Raises:
        MissingPackageError: as `require_package`.
    """
    require_package(package, purpose)
    return import_module(package)


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
