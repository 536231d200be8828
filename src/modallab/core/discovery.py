"""What is there is found by looking: packages of an extra, entry points, and modules that declare something.

What is added declares itself: the modules of a package each hold one declaration.

Packages are named, not imported, so that a lookup below may serve what is declared above it.
"""

import sys
from functools import lru_cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pkgutil import iter_modules
from types import ModuleType
from typing import TypeVar

from modallab.core.errors import ConfigurationError, MissingPackageError

Declared = TypeVar("Declared")
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


def declared_names(package: str) -> tuple[str, ...]:
    """Names of the modules of a package, in the order of the alphabet. None of them is imported."""
    return tuple(sorted(module.name for module in iter_modules(import_module(package).__path__)))


def declaration_in_module(package: str, name: str, attribute: str, kind: type[Declared]) -> Declared:
    """What one module of a package declares under `attribute`; importing the module is all it costs.

    Raises:
        ConfigurationError: it declares nothing, something else, or under another name than its file's.
    """
    module = f"{package}.{name}"
    found: object = getattr(import_module(module), attribute, None)
    if not isinstance(found, kind):
        raise ConfigurationError(
            f"{module} declares no {attribute}",
            remedy=f"add {attribute} = {kind.__name__}(...) to this module, or move the module out of the package",
        )
    if getattr(found, "name", name) != name:
        raise ConfigurationError(
            f"{module} declares itself as {getattr(found, 'name', None)!r}",
            remedy="give the object the name of its file",
        )
    return found


def declarations_in_package(package: str, attribute: str, kind: type[Declared]) -> dict[str, Declared]:
    """Module -> what it declares, for each module of a package, in alphabetical order; errors as "
    "`declaration_in_module`."""
    return {name: declaration_in_module(package, name, attribute, kind) for name in declared_names(package)}


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
