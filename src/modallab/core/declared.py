"""What a package holds, one declaration a module: adding a module adds what it declares."""

from collections.abc import Iterable
from importlib import import_module
from pkgutil import iter_modules
from typing import TypeVar

from modallab.core.errors import FormatError

T = TypeVar("T")


def declared(package: str, path: Iterable[str], name: str, kind: type[T]) -> dict[str, T]:
    """Module -> what it declares, for each module of a package, in alphabetical order.

    Args:
        package: its full name.
        path: its folders.
        name: of the declaration in every module.
        kind: type of the declarations.

    Raises:
        FormatError: a module declares nothing under this name.
    """
    found: dict[str, T] = {}
    for module in sorted(info.name for info in iter_modules(path)):
        value = getattr(import_module(f"{package}.{module}"), name, None)
        if not isinstance(value, kind):
            raise FormatError(
                f"{package}.{module} declares no {name}",
                remedy=f"add {name} = {kind.__name__}(...) to this module, or move it out of the package",
            )
        found[module] = value
    return found
