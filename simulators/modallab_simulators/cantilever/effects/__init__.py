"""Effects the bench can be given, one module each: adding a module with a `PART` adds one.

Those of the catalogue, and others that are none of it, for practising what to say then.
"""

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from modallab.core.discovery import declarations_in_package
from modallab.core.effects import EffectKind, catalogue
from modallab.core.errors import ConfigurationError
from modallab_simulators.cantilever.effect_part import EffectPart
from modallab_simulators.cantilever.learned import LEARNED_PARTS


@cache
def effect_parts() -> Mapping[str, EffectPart]:
    """Every effect's part, in the order in which they change the bench.

    Raises:
        FormatError: a module of this package declares no `PART`.
    """
    found = declarations_in_package(__name__, "PART", EffectPart).values()
    return MappingProxyType({part.name: part for part in sorted(found, key=lambda p: (p.rank, p.name))})


def part_of(name: str) -> EffectPart:
    """How this bench plays an effect, or a learned element.

    Raises:
        ConfigurationError: it can't.
    """
    part = effect_parts().get(name) or LEARNED_PARTS.get(name)
    if part is None:
        raise ConfigurationError(
            f"no effect is called {name!r}", remedy=f"use one of {', '.join(sorted(effect_parts()))}"
        )
    return part


def kinds() -> Mapping[str, EffectKind]:
    """Every effect this bench can be given: those of the catalogue, then its own."""
    known = {name: kind for name, kind in catalogue().items() if name in effect_parts()}
    return known | {name: part.outside for name, part in effect_parts().items() if part.outside is not None}


def allowed_range(part: EffectPart, name: str) -> tuple[float, float]:
    """Smallest and largest value of a parameter, both included; a parameter without sign starts above 0."""
    if name in part.limits:
        return part.limits[name]
    signed = any(p.name == name and p.signed for p in part.kind.parameters)
    return (float("-inf") if signed else 0.0), float("inf")
