"""Two accelerometers on exchanged rows."""

from dataclasses import replace

from modallab.core.effects import Effect, EffectKind
from modallab.core.rig import Rig
from modallab.twin.bench import Twin
from modallab.twin.effect_model import EffectModel, Search


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    first, second = effect.place["channel"]  # pyright: ignore[reportGeneralTypeIssues]
    return replace(twin, chain=replace(twin.chain, swap=(int(first), int(second))))


MODEL = EffectModel(
    kind=EffectKind(
        "swap",
        "sensor",
        (),
        "pair",
        "two channels are exchanged",
    ),
    rank=30,
    spoken="swap",
    change=_change,
    moves_poles=False,
    once=True,
    search=Search(rank=310, slots=lambda _: ()),
    experiment="Tap beside each of the two accelerometers: the row that reads more is its own.",
)
