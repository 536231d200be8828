"""Learned elements: what an effect without a name behaves like, one module each with a `MODEL`.

They are no causes, and so no entries of the catalogue: a diagnosis describes with them what none of its effects
explains.
"""

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from modallab.core.discovery import declarations_in_package
from modallab.twin.effect_model import EffectModel


@cache
def learned_element_models() -> Mapping[str, EffectModel]:
    """Every learned element's model.

    Raises:
        FormatError: a module of this package declares no `MODEL`.
    """
    found = declarations_in_package(__name__, "MODEL", EffectModel)
    return MappingProxyType({model.kind.name: model for model in sorted(found.values(), key=lambda m: m.rank)})
