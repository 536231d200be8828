"""Semi-real trials on FRFs of a structure: three modes in a line, with noise, driven at the first point."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from phased_line import model, rig

from modallab.blind.measured.draw import MeasuredRequest
from modallab.blind.measured.run import run_trials_on
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.modification.frfs import receptances_of_model


def measured(degrees: float) -> Frf:
    hz = np.arange(10.0, 95.0, 0.0625)
    s = np.asarray(2j * np.pi * hz)
    values = np.moveaxis(receptances_of_model(model(degrees=degrees), s) * (s**2)[:, None, None], 0, -1)
    rng = np.random.default_rng(0)
    noise = 1e-4 * (rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape))
    return Frf(hz, values + noise, "inertance", ("a1", "a2", "a3"), (1, 2, 3), (1,))


@pytest.mark.thorough("ten identifications")
def test_most_effects_are_named_and_nothing_done_is_no_gap(tmp_path: Path) -> None:
    found = run_trials_on(measured(10.0), rig(), tmp_path, MeasuredRequest(trials=8, none=2, seed=1))
    assert sum(t.right for t in found.trials if t.effect != "none") >= 6
    assert all(t.said == "no_gap" for t in found.trials if t.effect == "none")
    with pytest.raises(DataError, match="other trials"):
        run_trials_on(measured(10.0), rig(), tmp_path, MeasuredRequest(trials=1, none=1, seed=2))


def test_a_trial_without_modes_is_counted_and_ends_nothing(tmp_path: Path) -> None:
    clean = measured(0.0)
    # Noise of which a mode can be found only where nothing drowns it.
    loud = replace(clean, variance=np.full(clean.values.shape, 1e4))
    found = run_trials_on(loud, rig(), tmp_path, MeasuredRequest(trials=1, none=1, seed=1))
    assert [(t.said, t.right) for t in found.trials] == [("not_identified", False)] * 2
