"""Two accelerometers whose plugs are exchanged: each row takes the other's volts for its own."""

from contextlib import suppress
from dataclasses import replace

from modallab.core.effect import TwoChannels
from modallab.core.effects import Effect, EffectKind
from modallab.core.errors import RigError
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.signals.conversion import volts_per_si
from modallab.twin.bench import Twin
from modallab.twin.effect_model import EffectModel, EffectSearch


def _change(twin: Twin, effect: Effect, rig: Rig) -> Twin:
    assert isinstance(effect.place, TwoChannels)
    pair = effect.place.channel
    return replace(twin, chain=replace(twin.chain, swap=pair, swap_ratio=_ratio_of_sensitivities(rig, *pair)))


def _ratio_of_sensitivities(rig: Rig, first: int, second: int) -> dict[Test, float]:
    found: dict[Test, float] = {}
    for test in ("impact", "sine"):
        # A rig without a sensitivity for a test has no such test.
        with suppress(RigError):
            volts = volts_per_si(rig, test)
            found[test] = float(volts[second] / volts[first])
    return found


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
    search=EffectSearch(rank=310, slots=lambda _: ()),
    experiment="Tap beside each of the two accelerometers: the row with the larger reading belongs to that "
    "accelerometer.",
)
