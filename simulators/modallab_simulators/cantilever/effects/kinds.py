"""The kinds of effects this bench knows, and what their numbers may be."""

from collections.abc import Mapping
from math import inf

from modallab.core.effects import CATALOGUE, EffectKind
from modallab_simulators.cantilever.effects.outside import OUTSIDE

KINDS: Mapping[str, EffectKind] = {**CATALOGUE, **OUTSIDE}

OPTIONS: Mapping[str, tuple[str, ...]] = {
    "thermal_drift": ("over_s",),
    "clipping": ("peak_v",),
    "clearance": ("k_within",),
}
"""Numbers that say how this bench plays an effect, and are no part of the effect: over how many seconds of bench time a
drift runs; what a channel would reach, if the bench shall not work it out from its hardest hit; what still holds the
root within the play."""

LIMITS: Mapping[str, tuple[float, float]] = {
    "EI_loss": (0.0, 0.99),
    "EI_loss_open": (0.0, 0.99),
    "EI_drift": (-0.9, 9.0),
    "zeta": (0.0, 0.9),
    "fraction_of_peak": (0.0, 1.0),
    "relative": (-0.2, 0.2),
    "seconds": (0.0, 0.02),
    "seconds_per_channel": (0.0, 0.001),
    "sign": (-1.0, -1.0),
    "share": (0.0, 1.0),
}
"""Beyond these a number makes no sense, or no bench."""


def allowed(kind: EffectKind, name: str) -> tuple[float, float]:
    """Smallest and largest value of a parameter, both included; a parameter without sign starts above 0."""
    if name in LIMITS:
        return LIMITS[name]
    signed = any(p.name == name and p.signed for p in kind.parameters)
    return (-inf if signed else 0.0), inf
