"""The size of what hangs at a driven point comes from the FRFs themselves, whatever a modal model misses of them."""

import numpy as np
import pytest
from phased_line import model, rig

from modallab.blind.measured.draw import AppliedEffect, with_effect
from modallab.core.frf import Frf
from modallab.gap.modal.diagnosis import diagnose_by_model
from modallab.identification.frf_model import identify_frf
from modallab.identification.options import IdentificationOptions
from modallab.modification.frfs import receptances_of_model


def distorted(seed: int = 0) -> Frf:
    """FRFs that no three modes hold: distorted by 4 % over a few Hz, otherwise in each."""
    hz = np.arange(10.0, 95.0, 0.0625)
    s = np.asarray(2j * np.pi * hz)
    values = np.moveaxis(receptances_of_model(model(degrees=4.0), s) * (s**2)[:, None, None], 0, -1)
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi, (*values.shape[:2], 1))
    return Frf(hz, values * (1 + 0.04 * np.sin(hz / 1.3 + phase)), "inertance", ("a1", "a2", "a3"), (1, 2, 3), (1,))


@pytest.mark.parametrize(
    ("effect", "value", "name"),
    [
        ("added_mass", 1.2, "mass"),
        pytest.param("ground_spring", 3e4, "k", marks=pytest.mark.thorough("identifies and diagnoses once more")),
    ],
)
def test_a_size_is_exact_where_the_modal_model_is_not(effect: str, value: float, name: str) -> None:
    before = distorted()
    after = with_effect(before, AppliedEffect(effect, value, output=0, input=0))
    models = [identify_frf(frf, rig(), IdentificationOptions())[0] for frf in (before, after)]
    (found,) = diagnose_by_model(models[0], models[1], rig(), frfs=(before, after)).effects
    assert (found.effect, found.place.point) == (effect, 1)
    assert found.parameters[name] == pytest.approx(value, rel=0.03)
