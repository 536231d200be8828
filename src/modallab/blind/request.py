"""Which blind trials are made."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from modallab.blind.trial_bench import trial_bench
from modallab.core.frozen import Frozen


class BlindRequest(Frozen):
    """Which trials are made.

    Attributes:
        trials: with one effect.
        none: without effect.
        pairs: with two effects.
        seed: draws everything.
        effects: names; empty for the whole catalogue.
        tolerances: how well the benches are put together: ideally, or as in an ordinary lab.
        later: whether each diagnosis is compared with a later campaign on the same bench.
    """

    trials: Annotated[int, Field(ge=0, le=100_000)] = 60
    none: Annotated[int, Field(ge=0, le=100_000)] = 20
    pairs: Annotated[int, Field(ge=0, le=100_000)] = 0
    seed: Annotated[int, Field(ge=0, lt=2**32)] = 0
    effects: tuple[str, ...] = ()
    tolerances: Literal["none", "usual"] = "none"
    later: bool = True

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not self.trials + self.none + self.pairs:
            raise ValueError("no trial is requested")
        known = trial_bench().kinds()
        strange = [name for name in self.effects if name not in known]
        if strange:
            raise ValueError(f"no effect is called {', '.join(strange)}: use {', '.join(sorted(known))}")
        return self
