"""The bare link from a measurement with sensors of 3 to 15 g and a stinger on it, then measured bare.

    python benchmarks/unloaded.py 8 benchmarks/results/unloaded.csv

Each bench is as built in an ordinary lab, and no other one. A stinger is 5 to 30 g and 100 to 1000 N/m at the free end.
What hangs on the link is known, and taken away in the model. A row is a mode below half the band.
"""

import sys
from pathlib import Path

import numpy as np

import modallab as ml
from by_seed import measure
from modallab.core.rig import Tolerance
from modallab.modification.attachments import Element
from modallab.modification.known import KnownStructure
from modified import COLUMNS, PLAN, POINTS, beside, summary

FIRST_SEED = 7351


def rows_of(seed: int) -> list[list[object]]:
    """Predicted and measured modes of one bench."""
    rng = np.random.default_rng(seed)
    drawn = (np.exp(rng.uniform(*np.log(r))) for r in ((3e-3, 15e-3), (5e-3, 0.03), (1e2, 1e3)))
    sensor, kg, stiff = (float(f"{number:.4g}") for number in drawn)
    loaded = (f"sensor_mass,mass_each={sensor}", f"added_mass,mass={kg},x=1.0", f"ground_spring,k={stiff},x=1.0")
    tests = [ml.simulate("link", e, seed=seed, tolerances="usual", plan=PLAN, progress=False) for e in (loaded, ())]
    with_all, bare = (ml.identify(test, "impact", progress=False) for test in tests)
    rig = bare.campaign.rig.model_copy(update={"tolerance": Tolerance.usual()})
    away = [*(Element(p, mass=-sensor) for p in range(1, POINTS + 1)), Element(POINTS, mass=-kg, spring=-stiff)]
    after = KnownStructure(with_all.modal_model, rig).with_changes(away).modes
    return beside("unloaded", seed, sensor, POINTS, with_all.modal_model, after, bare.modal_model)


if __name__ == "__main__":
    measure(rows_of, COLUMNS, summary, FIRST_SEED, int(sys.argv[1]), Path(sys.argv[2]))
