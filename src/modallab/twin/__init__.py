"""The cantilever as a model: finite elements, measurement chain, effects, prediction of records."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazily

if TYPE_CHECKING:
    from modallab.twin.base_motion import base_transmission
    from modallab.twin.bench import Chain, Mount, Twin, transfer
    from modallab.twin.effects import apply
    from modallab.twin.modes import Modes, solve
    from modallab.twin.predict import predict_hit, predict_sine
    from modallab.twin.response import Hits, Rise, Sines
    from modallab.twin.structure import Structure, believed_root

__all__ = [
    "Chain",
    "Hits",
    "Modes",
    "Mount",
    "Rise",
    "Sines",
    "Structure",
    "Twin",
    "apply",
    "base_transmission",
    "believed_root",
    "predict_hit",
    "predict_sine",
    "solve",
    "transfer",
]

__getattr__ = lazily(
    __name__,
    {
        "base_motion": ("base_transmission",),
        "bench": ("Chain", "Mount", "Twin", "transfer"),
        "effects": ("apply",),
        "modes": ("Modes", "solve"),
        "predict": ("predict_hit", "predict_sine"),
        "response": ("Hits", "Rise", "Sines"),
        "structure": ("Structure", "believed_root"),
    },
)
