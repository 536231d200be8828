"""An effect that is another one but for tolerances goes by that one's name."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.effects import Effect
from modallab.core.rig import Tolerance
from modallab.gap.conditioning.prepare import prepare
from modallab.gap.model.candidates import of_channel
from modallab.gap.model.fit import Problem, seen
from modallab.gap.report.initial_gap import bench_of, free_of
from modallab.gap.search.fitting import COARSE, finish
from modallab.gap.search.simplest import simplest


@pytest.mark.parametrize(("gain", "named"), [(-0.995, "polarity"), (-0.8, "gain_error"), (0.8, "gain_error")])
def test_a_gain_near_minus_one_is_a_wrong_sign(rig, make, gain, named):
    wrong = Effect(effect="gain_error", parameters={"gain": gain}, place={"channel": 3})
    prepared = prepare(replace(make(wrong), rig=rig.model_copy(update={"tolerance": Tolerance.usual()})))
    whole = bench_of(prepared, prepared.blocks, free_of(prepared.campaign), lambda _: True)
    bench = replace(whole, data=whole.thin)
    candidate = next(c for c in of_channel(bench.data.rig, 3) if c.effect == "gain_error")
    u = np.append(np.zeros(bench.free.size), candidate.slots[0].coordinate(gain))
    found = finish(bench, seen(Problem(bench.thin, bench.free, (candidate,)), u), COARSE / 6)
    simple = simplest(bench, found)
    assert [e.effect for e in simple.effects] == [named]
    assert simple.gap <= bench.flat
    # Where it may not be named, it stays what it was.
    withheld = simplest(replace(bench, allowed=lambda name: name != "polarity"), found)
    assert [e.effect for e in withheld.effects] == ["gain_error"]
