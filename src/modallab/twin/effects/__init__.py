"""The effects of the catalogue, one module each: adding a module with a `MODEL` adds an effect."""

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

from modallab.core.discovery import declarations_in_package
from modallab.core.effects import STAGES, Effect, EffectKind
from modallab.core.errors import FormatError
from modallab.core.rig import Rig
from modallab.twin.bench import Twin
from modallab.twin.effect_model import EffectModel, EffectSearch, NoChange
from modallab.twin.learned import learned_element_models


@cache
def effect_models() -> Mapping[str, EffectModel]:
    """Every effect's model, in the order of the catalogue.

    Raises:
        FormatError: a module of this package declares no `MODEL`, or one of another name than its own.
    """
    found = declarations_in_package(__name__, "MODEL", EffectModel)
    for module, model in found.items():
        if model.kind.name != module:
            raise FormatError(
                f"{__name__}.{module} declares the effect {model.kind.name!r}",
                remedy="give the module the name of its effect",
            )
    ordered = sorted(found.values(), key=lambda m: (STAGES.index(m.kind.stage), m.rank, m.kind.name))
    return MappingProxyType({m.kind.name: m for m in ordered})


def kinds() -> list[EffectKind]:
    """The entries of the catalogue; its entry point."""
    return [m.kind for m in effect_models().values()]


def model_of(name: str) -> EffectModel:
    """The model of an effect, or of a learned element.

    Raises:
        FormatError: the catalogue has no such effect.
    """
    model = effect_models().get(name) or learned_element_models().get(name)
    if model is None:
        raise FormatError(f"no effect is called {name!r}", remedy=f"use one of {', '.join(sorted(effect_models()))}")
    return model


def search_of(name: str) -> EffectSearch:
    """How a fit looks for an effect.

    Raises:
        FormatError: the catalogue has no such effect, or no fit looks for it.
    """
    search = model_of(name).search
    if search is None:
        raise FormatError(f"no fit looks for {name!r}", remedy="use an effect of which the twin has a model")
    return search


def apply_effect(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    """The twin with an effect in it; what a force cannot predict (noise, hum, ringing, floor) leaves it unchanged.

    Raises:
        FormatError: the twin has no model of this effect.
    """
    model = effect_models().get(effect.effect) or learned_element_models().get(effect.effect)
    change = model.change if model is not None else NoChange.NO_MODEL_YET
    if change is NoChange.NO_FORCE_PREDICTS_IT:
        return twin
    if isinstance(change, NoChange):
        able = sorted(name for name, model in effect_models().items() if not isinstance(model.change, NoChange))
        raise FormatError(f"the twin has no model of {effect.effect!r}", remedy=f"use one of {', '.join(able)}")
    return change(twin, effect, rig)


def with_revision_effects(twin: Twin, rig: Rig) -> Twin:
    """The twin with the effects that the rig's revisions know."""
    for effect in rig.known_effects:
        twin = apply_effect(twin, effect, rig)
    return twin
