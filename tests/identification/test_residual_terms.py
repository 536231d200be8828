"""An acceleration that follows the force, as modes far above the band leave it, must not pass for damping."""

from dataclasses import replace

import modal_bench as bench
import numpy as np

from modallab.identification.impact import identify_impact
from modallab.identification.options import Options
from modallab.signals.hit import find_hit, windowed_force
from modallab.signals.signals import to_signals_of


def test_a_share_of_the_force_in_every_response_moves_no_damping():
    rng = np.random.default_rng(5)
    system, rig = bench.modes(rng), bench.rig(5)
    signals = to_signals_of(bench.impact_blocks(system, rng, points=(5,), hits=4), rig)
    share = np.linspace(-1e-2, 5e-2, 5)[:, None]
    mixed = [replace(s, responses=s.responses + share * windowed_force(s.force, find_hit(s.force))) for s in signals]
    plain = identify_impact(signals, rig, Options())[0]
    model = identify_impact(mixed, rig, Options())[0]
    np.testing.assert_allclose(model.damping_ratio, plain.damping_ratio, atol=0.5 * plain.damping_sigma.min())
    for found, sigma, true in zip(model.damping_ratio, model.damping_sigma, system.zeta, strict=True):
        assert abs(found - true) < 4 * sigma
