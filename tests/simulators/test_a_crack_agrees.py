"""The twin predicts noise-free sines of the simulated bench with a crack that opens, shallow and deep.

Both know the same crack in different ways: the bench by the curvature it adds, the twin by the stiffness it takes.
"""

from dataclasses import replace

import pytest
from test_twin_agrees import LINES, RIG, SEED, measured, predicted, size, sound, sound_twin

from modallab.core.effects import Effect
from modallab.twin.nonlinear.element import NonlinearElement, NonlinearLaw
from modallab_simulators.cantilever.cracked import HALF_WIDTH
from modallab_simulators.cantilever.trial import SessionOperator

X = 0.31
LEFT = 0.05
"""Of the gap it opens; without a filter against what folds back it would be twice as much."""


@pytest.mark.thorough("steps both models in time")
@pytest.mark.parametrize("share", [0.2, 0.9])
def test_the_gap_a_crack_opens_closes(share: float):
    crack = Effect(effect="breathing_crack", parameters={"EI_loss_open": share}, place={"x": X})
    intact = sound_twin()
    length = intact.structure.length_m
    twin = replace(intact, element=NonlinearElement(NonlinearLaw.CRACK, X * length, (share, HALF_WIDTH * length, 1.0)))
    blocks = SessionOperator(RIG, SEED, (crack,)).sines(LINES)
    for (y, expected), block in zip(sound("sine"), blocks, strict=False):
        found = measured(block) - (y - expected)
        assert size(found - predicted(twin, block)) < LEFT * size(found - predicted(intact, block))
