"""Learned elements on the bench: what a diagnosis says that a gap behaves like, one module each with a `PART`.

They are played where a rig's revisions hold them. No blind trial draws them: they are no effects.
"""

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from modallab.core.discovery import declarations_in_package
from modallab_simulators.cantilever.effect_part import EffectPart


@cache
def learned_parts() -> Mapping[str, EffectPart]:
    """Every learned element's part.

    Raises:
        ConfigurationError: a module of this package declares no `PART`.
    """
    return MappingProxyType(declarations_in_package(__name__, "PART", EffectPart))
