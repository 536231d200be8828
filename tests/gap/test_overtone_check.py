"""A law is known by the overtones it makes: no fit has seen them."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.conditioning.reduce import reduce_blocks
from modallab.gap.model.fit import Fit, Problem
from modallab.gap.report.initial_gap import nuisances_of_campaign, weights_of
from modallab.gap.search.overtone_check import overtones_closed
from modallab.twin.effects import model_of

DRAG = Effect(effect="air_drag", parameters={"c2_total": 60.0}, place={"x": "all"})


@pytest.mark.parametrize(("c2_total", "closed"), [(60.0, (0.6, 1.0)), (6.0, (0.0, 0.3))])
def test_a_drag_makes_the_overtones_that_were_measured_and_one_of_another_size_does_not(
    make: Callable[..., Campaign], c2_total: float, closed: tuple[float, float]
) -> None:
    prepared = prepare_campaign(make(DRAG, tests=("sine",)))
    data, free = (
        reduce_blocks(prepared.campaign, prepared.blocks, weights_of(prepared)),
        nuisances_of_campaign(prepared.campaign),
    )
    assert data.sines is not None
    data = replace(data, sines=replace(data.sines, pieces=data.sines.pieces[-4:]))
    candidate = model_of("air_drag").candidates(data.rig)[0]
    u = np.concatenate([np.zeros(free.size), [candidate.slots[0].coordinate(c2_total)]])
    fit = Fit(Problem(data, free, (candidate,)), u, 0.0, np.zeros(1), np.eye(len(u)))
    assert closed[0] <= overtones_closed(fit, prepared, data) <= closed[1]
