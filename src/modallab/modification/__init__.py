"""A structure known by its modal model: its FRFs at any pair, its response to a force, what a change makes of it."""

from typing import TYPE_CHECKING

from modallab.core.lazy import lazily

if TYPE_CHECKING:
    from modallab.modification.attachments import Addition, Coupled, Element, RigidLink, TunedAbsorber
    from modallab.modification.inverse import Answer, best_absorber, tuned
    from modallab.modification.known import Known
    from modallab.modification.modified import ModesAfter
    from modallab.modification.state_space import ModalStateSpace
    from modallab.modification.synthesis import synthesised

__all__ = [
    "Addition",
    "Answer",
    "Coupled",
    "Element",
    "Known",
    "ModalStateSpace",
    "ModesAfter",
    "RigidLink",
    "TunedAbsorber",
    "best_absorber",
    "synthesised",
    "tuned",
]

__getattr__ = lazily(
    __name__,
    {
        "attachments": ("Addition", "Coupled", "Element", "RigidLink", "TunedAbsorber"),
        "inverse": ("Answer", "best_absorber", "tuned"),
        "known": ("Known",),
        "modified": ("ModesAfter",),
        "state_space": ("ModalStateSpace",),
        "synthesis": ("synthesised",),
    },
)
