"""The catalogue of effects: names, parameters, SI units, ranges and stage.

Twin and simulator both speak it; neither shares more than these names with the other. The entries are declared with the
twin's models, one file an effect, and found by entry point.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Literal, cast, get_args

from modallab.core.discovery import installed_entry_points
from modallab.core.effect import AllAlongBeam, AllChannels, AlongBeam, Effect, FixedPlace, NoPlace, OneChannel, Place
from modallab.core.errors import FormatError
from modallab.core.rig import Beam, Rig
from modallab.core.units import Test

Stage = Literal["structure", "sensor", "acquisition", "excitation"]
PlaceKind = Literal["none", "all", "x", "root", "shaker", "channel", "force", "pair", "base", "hit", "impact"]
Scale = Literal["one", "EI/L", "EI/L^3", "m", "sqrt(EI m/L^3)", "L"]

__all__ = [
    "GROUP",
    "STAGES",
    "Effect",
    "EffectKind",
    "Parameter",
    "PlaceKind",
    "Scale",
    "Stage",
    "catalogue",
    "kind_of",
]

GROUP = "modallab.effects"
"""Entry points to functions without arguments that return entries of the catalogue."""

STAGES: tuple[Stage, ...] = get_args(Stage)


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of an effect.

    Attributes:
        name: its name in every file.
        unit: its SI unit; "" for a pure number.
        low: smallest magnitude worth a look, in `scale`.
        high: largest.
        scale: what `low` and `high` are multiples of; EI/L and so on are those of the beam, m its mass.
        signed: whether the number may have either sign (the range is then that of its magnitude).
        none: where the number stands for no effect; the range is that of the distance from it.
        spoken: what a report calls it, where the name does not say it.
    """

    name: str
    unit: str
    low: float
    high: float
    scale: Scale = "one"
    signed: bool = False
    none: float = 0.0
    spoken: str = ""

    @property
    def in_words(self) -> str:
        """What a report calls it."""
        return self.spoken or self.name.replace("_", " ")

    def bounds(self, beam: Beam) -> tuple[float, float]:
        """Smallest and largest magnitude on this beam, SI."""
        factor = _SCALES[self.scale](beam)
        return self.low * factor, self.high * factor


@dataclass(frozen=True, slots=True)
class EffectKind:
    """One entry of the catalogue.

    Attributes:
        name: the effect's name in every file.
        stage: where in the chain it acts.
        parameters: in the order of the files.
        place: what its place is. x is a share of the beam's length, from the clamp. Channel numbers are those of the
            rig: 0 the force, k the accelerometer in row k.
        tests: the tests it shows in.
        linear: whether the bench with it still answers in proportion to the force.
        says: what it does, in one line, with the convention of its parameters.
        at_points: its number on a structure that is known at points alone, where that is not the first parameter.
    """

    name: str
    stage: Stage
    parameters: tuple[Parameter, ...]
    place: PlaceKind
    says: str
    tests: tuple[Test, ...] = ("impact", "sine")
    linear: bool = True
    at_points: Parameter | None = None

    @property
    def fixed_place(self) -> Place | None:
        """The place of every effect of this kind; None if it is a choice, or the rig's (x, channel, pair, shaker)."""
        if self.place == "all":
            return AllAlongBeam() if self.stage == "structure" else AllChannels()
        return _FIXED.get(self.place)

    def parameter(self, name: str) -> Parameter:
        """The parameter of this name.

        Raises:
            FormatError: there is none.
        """
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise FormatError(
            f"{self.name} has no parameter {name!r}",
            remedy=f"use {', '.join(p.name for p in self.parameters) or 'none: it has no parameters'}",
        )


def x_of(effect: Effect, rig: Rig) -> float:
    """Where an effect on the beam is, in m from the clamp."""
    assert rig.beam is not None
    assert isinstance(effect.place, AlongBeam)
    return effect.place.x * rig.beam.length_m


def row_of(effect: Effect) -> int:
    """The row of an effect on one channel."""
    assert isinstance(effect.place, OneChannel)
    return effect.place.channel


def kind_of(name: str) -> EffectKind:
    """The catalogue's entry of this name.

    Raises:
        FormatError: the catalogue has no such effect.
    """
    known = catalogue()
    if name not in known:
        raise FormatError(f"no effect is called {name!r}", remedy=f"use one of {', '.join(sorted(known))}")
    return known[name]


@cache
def catalogue() -> Mapping[str, EffectKind]:
    """Every effect with a name, in the order of the stages."""
    loaded = (cast("Callable[[], Iterable[EffectKind]]", entry.load())() for entry in installed_entry_points(GROUP))
    kinds = sorted((kind for some in loaded for kind in some), key=lambda kind: STAGES.index(kind.stage))
    return MappingProxyType({kind.name: kind for kind in kinds})


_FIXED: dict[PlaceKind, Place] = {
    "none": NoPlace(),
    "root": AlongBeam(x=0.0),
    "force": OneChannel(channel=0),
    "base": FixedPlace(where="base"),
    "hit": FixedPlace(where="hit"),
    "impact": FixedPlace(where="impact"),
}
_SCALES: dict[Scale, Callable[[Beam], float]] = {
    "one": lambda _: 1.0,
    "EI/L": lambda b: b.bending_stiffness_n_m2 / b.length_m,
    "EI/L^3": lambda b: b.bending_stiffness_n_m2 / b.length_m**3,
    "m": lambda b: b.mass_kg,
    "sqrt(EI m/L^3)": lambda b: (b.bending_stiffness_n_m2 * b.mass_kg / b.length_m**3) ** 0.5,
    "L": lambda b: b.length_m,
}
