"""Public faces of packages that cost nothing until a name is used."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def lazily(package: str, places: Mapping[str, str]) -> Callable[[str], Any]:
    """A package's `__getattr__`, which imports a public name from its module on first use.

    Args:
        package: the package's `__name__`.
        places: public name -> module it stands in, relative to the package.
    """

    def find(name: str) -> Any:
        if name not in places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}", name=name, obj=None)
        return getattr(import_module(f"{package}.{places[name]}"), name)

    return find
