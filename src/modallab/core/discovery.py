"""What is added declares itself: the modules of a package each hold one declaration, and are found by looking."""

from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import TypeVar

from modallab.core.errors import ConfigurationError

Declared = TypeVar("Declared")


def declared_names(package: ModuleType) -> tuple[str, ...]:
    """Names of the modules of `package`, in the order of the alphabet. None of them is imported."""
    return tuple(sorted(module.name for module in iter_modules(package.__path__)))


def declaration(package: ModuleType, name: str, attribute: str, kind: type[Declared]) -> Declared:
    """What one module of `package` declares under `attribute`; importing the module is all it costs.

    Raises:
        ConfigurationError: it declares nothing, something else, or under another name than its file's.
    """
    module = f"{package.__name__}.{name}"
    found: object = getattr(import_module(module), attribute, None)
    if not isinstance(found, kind):
        raise ConfigurationError(
            f"{module} declares no {attribute}",
            remedy=f"set {attribute} to a {kind.__module__}.{kind.__name__}, or take the file out of its folder",
        )
    if getattr(found, "name", name) != name:
        raise ConfigurationError(
            f"{module} declares itself as {getattr(found, 'name', None)!r}", remedy="give it the name of its file"
        )
    return found
