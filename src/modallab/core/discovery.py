"""What is added declares itself: the modules of a package each hold one declaration, and are found by looking.

Packages are named, not imported, so that a lookup below may serve what is declared above it.
"""

from importlib import import_module
from pkgutil import iter_modules
from typing import TypeVar

from modallab.core.errors import ConfigurationError

Declared = TypeVar("Declared")


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
            remedy=f"add {attribute} = {kind.__name__}(...) to this module, or move it out of the package",
        )
    if getattr(found, "name", name) != name:
        raise ConfigurationError(
            f"{module} declares itself as {getattr(found, 'name', None)!r}", remedy="give it the name of its file"
        )
    return found


def declarations_in_package(package: str, attribute: str, kind: type[Declared]) -> dict[str, Declared]:
    """Module -> what it declares, for each module of a package, in alphabetical order; errors as "
    "`declaration_in_module`."""
    return {name: declaration_in_module(package, name, attribute, kind) for name in declared_names(package)}
