"""A structure that drifts, laid between three assembled ones, against the same assembled anew at every step."""

import numpy as np
import pytest
from noiseless_bench import driven

from modallab.cli.demo import demo_rig
from modallab_simulators.cantilever import stream
from modallab_simulators.cantilever.address import parse_address
from modallab_simulators.cantilever.basis import Basis
from modallab_simulators.cantilever.drifting_structure import BetweenBases, DriftingStructure
from modallab_simulators.cantilever.truth import draw_truth

TEN_SECONDS = "thermal_drift,EI_drift=5e-4,over_s=10"
BUILT = "seed=4&tolerances=usual"


class Anew(DriftingStructure):
    def basis(self, progress: float) -> Basis:
        return self._at(progress)


def test_what_the_bench_reads_is_that_of_a_structure_assembled_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    between = driven(TEN_SECONDS, f_hz=29.0, seconds=1.5, query=BUILT)
    monkeypatch.setattr(stream, "DriftingStructure", Anew)
    anew = driven(TEN_SECONDS, f_hz=29.0, seconds=1.5, query=BUILT)
    # A drift that stood still would be off by 5e-4.
    assert np.max(np.max(np.abs(between - anew), axis=1) / np.max(np.abs(anew), axis=1)) < 5e-7


@pytest.mark.parametrize(
    ("effect", "between"),
    [
        ("thermal_drift,EI_drift=5e-4", True),
        ("thermal_drift,EI_drift=0.1", False),
        # What hangs there swings almost as the second mode does: as that passes by, both change their shapes.
        ("support_resonance,mass=1e-5,hz=30.6,x=0.4&effect=thermal_drift,EI_drift=5e-4", False),
    ],
)
def test_only_what_moves_along_a_line_is_laid_between(effect: str, between: bool) -> None:
    rig = demo_rig()
    truth = draw_truth(parse_address(f"sim://cantilever?seed=1&effect={effect}"), rig)
    drifting = DriftingStructure(lambda progress: truth.basis(2000.0, "impact", progress, 4))
    assert isinstance(drifting.basis(0.3), BetweenBases) is between
