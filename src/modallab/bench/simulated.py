"""The address of the simulated bench, with effects that were looked at before anything is started."""

from collections.abc import Sequence
from math import sqrt
from urllib.parse import quote

from modallab.bench.loader import open_bench
from modallab.core.effects import EffectKind, catalogue
from modallab.core.errors import ConfigurationError
from modallab.core.rig import Rig

_PLACES = {"x": "x=0.8", "channel": "channel=a03", "pair": "channel=a03:a07"}


def simulated_bench(rig: Rig, seed: int, effects: Sequence[str] = (), tolerances: str = "none") -> str:
    """The address of the simulated bench with these effects.

    Args:
        rig: what stands on it.
        seed: draws the bench and its noise.
        effects: each as added_mass,mass=0.05,x=0.8.
        tolerances: none, usual, or stated for those of the rig file.

    Raises:
        ConfigurationError: an effect that there is not, or a number or place of it that is missing or cannot be.
    """
    built = "" if tolerances == "none" else f"&tolerances={tolerances}"
    url = f"sim://cantilever?seed={seed}{built}"
    for effect in effects:
        try:
            open_bench(f"{url}{_added_effect(effect)}", rig).close()
        except ConfigurationError as error:
            raise ConfigurationError(
                error.what.replace("\n", "; "), where=f"effect {effect}", remedy=_remedy(effect, rig)
            ) from error
    url += "".join(map(_added_effect, effects))
    open_bench(url, rig).close()
    return url


def example_effect(kind: EffectKind, rig: Rig) -> str:
    """An effect of this kind, large enough to be seen in a test: added_mass,mass=0.05,x=0.8."""
    words = [kind.name]
    for number in kind.parameters:
        low, high = (number.low, number.high) if rig.beam is None else number.bounds(rig.beam)
        words.append(f"{number.name}={number.none + sqrt(low * high):.3g}")
    return ",".join([*words, *([_PLACES[kind.place]] if kind.place in _PLACES else [])])


def _added_effect(effect: str) -> str:
    return f"&effect={quote(effect, safe=',=')}"


def _remedy(effect: str, rig: Rig) -> str:
    name = effect.partition(",")[0].strip()
    if name in catalogue():
        return f"write it as {example_effect(catalogue()[name], rig)}; modallab gap effects {name} describes it"
    return "modallab demo --effect help lists them; write one as added_mass,mass=0.05,x=0.8"
