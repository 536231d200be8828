"""What blind trials ask of this bench: effects drawn to a size, and whole campaigns in a moment."""

from modallab_simulators.cantilever.draw_effect import draw_effect, draw_gap
from modallab_simulators.cantilever.effects import kinds
from modallab_simulators.cantilever.trial import make_trial

__all__ = ["draw_effect", "draw_gap", "kinds", "make_trial"]
