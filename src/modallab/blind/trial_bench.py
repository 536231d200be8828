"""The bench that blind trials are made on, found by entry point: modallab names no simulator."""

from collections.abc import Mapping, Sequence
from typing import Protocol, cast

from modallab.core.block import Campaign
from modallab.core.discovery import installed_entry_points
from modallab.core.effects import Effect, EffectKind
from modallab.core.errors import ConfigurationError
from modallab.core.rig import Rig

GROUP = "modallab.trials"
"""Entry points to modules that offer what `TrialBench` asks."""


class DrawnEffect(Protocol):
    """An effect of a size, and the gap in noise units it opens on an ideal bench."""

    @property
    def effect(self) -> Effect:
        """With its numbers."""
        ...

    @property
    def gap(self) -> float:
        """In noise units."""
        ...

    @property
    def moves(self) -> float:
        """Share of the response that it moves, on the channel and in the test where it is most."""
        ...


class TrialBench(Protocol):
    """What makes trials: a simulated bench that draws effects and measures whole campaigns."""

    def kinds(self) -> Mapping[str, EffectKind]:
        """Every effect it can be given, those of no catalogue among them."""
        ...

    def draw_gap(self, seed: int) -> float:
        """A size of the gap in noise units, as a seed draws it."""
        ...

    def draw_effect(self, rig: Rig, seed: int, name: str, requested: float | None = None) -> DrawnEffect:
        """Where and how an effect is, scaled until it opens a gap of the requested size."""
        ...

    def make_trial(
        self, rig: Rig, seed: int, effects: Sequence[Effect] = (), tolerances: str = "none", session: int = 0
    ) -> tuple[Campaign, dict[str, object]]:
        """A campaign and its truth; another session is another campaign on the same bench."""
        ...


def trial_bench() -> TrialBench:
    """The bench for trials that is installed.

    Raises:
        ConfigurationError: there is none.
    """
    found = sorted(installed_entry_points(GROUP), key=lambda entry: entry.name)
    if not found:
        raise ConfigurationError("no simulated bench for blind trials is installed", remedy="install modallab again")
    return cast("TrialBench", found[0].load())
