"""Every frequency response function begins as scaled, mean-free blocks: steps A, B and C of the paper."""

import sys
from importlib import import_module
from types import ModuleType
from typing import Any


class _Callable(ModuleType):
    """This package once it is imported, under a name that it shares with a function: `modallab.frf(f, H)`."""

    def __call__(self, f: Any, H: Any, inputs: Any = None, outputs: Any = None, quantity: Any = "inertance") -> Any:
        """As `modallab.notebook.measured_frf.frf`: FRFs from arrays."""
        return import_module("modallab.notebook.measured_frf").frf(f, H, inputs, outputs, quantity)


# Importing it puts it in the place of the function, for whoever writes `import modallab as ml; ml.frf(...)`.
sys.modules[__name__].__class__ = _Callable
