"""What no kind of change explains is unknown, and is worded like any other answer."""

import numpy as np
import pytest
from phased_line import OMEGA, PSI, model, rig

from modallab.gap.modal.compared import compared
from modallab.gap.modal.diagnosis import diagnose_by_model
from modallab.gap.modal.fitting import fit
from modallab.gap.modal.free import Free
from modallab.gap.modal.linear import Linear
from modallab.gap.modal.matching import Side
from modallab.gap.model.tolerances import with_tolerances


def _risen(mode: int, by: float) -> np.ndarray:
    omega = OMEGA.copy()
    omega[mode] *= by
    return omega


def test_a_mode_that_no_change_makes_is_unknown() -> None:
    """One mode rises by a quarter and the next one falls: no mass, spring or gain does that."""
    omega = OMEGA.copy()
    omega[:2] *= (1.25, 0.85)
    twisted = PSI.copy()
    twisted[1] = twisted[1][::-1]
    found = diagnose_by_model(model(), model(twisted, omega), rig())
    assert (found.verdict, found.effects) == ("unknown", [])
    assert np.isfinite(found.after)
    assert len(found.by_mode) > 0


@pytest.mark.thorough("diagnoses a structure once more")
def test_a_channel_that_turns_each_mode_by_itself_is_no_change_of_the_structure() -> None:
    reference, turn = model(), np.exp(0.09j * np.random.default_rng(1).standard_normal((OMEGA.size, 1)))
    constants = reference.modal_constants.copy()
    constants[:, 1] *= turn
    found = diagnose_by_model(reference, reference.model_copy(update={"modal_constants": constants}), rig())
    assert found.verdict == "unknown"
    assert max(e.probability for e in found.candidates) < 0.5


@pytest.mark.parametrize(("reading", "read"), [(2, 0), (0, 1)])
def test_a_share_of_another_channel_is_no_moved_sensor(reading: int, read: int) -> None:
    """Shapes between three points are free enough for both: only a share is alike in all modes."""
    reference = model()
    constants = reference.modal_constants.copy()
    constants[:, reading] += 0.3 * constants[:, read]
    found = diagnose_by_model(reference, reference.model_copy(update={"modal_constants": constants}), rig())
    assert (found.verdict, found.effects) == ("unknown", [])
    assert any(f"a{reading + 1} reads what another channel should" in note for note in found.notes)


@pytest.mark.thorough("diagnoses a structure once more")
def test_a_gain_that_a_share_of_others_may_be_keeps_its_name() -> None:
    reference = model()
    constants = reference.modal_constants.copy()
    constants[:, 1] *= 1.3
    found = diagnose_by_model(reference, reference.model_copy(update={"modal_constants": constants}), rig())
    assert [e.effect for e in found.effects] == ["gain_error"]


def test_what_a_scale_of_its_own_gains_is_the_difference_of_two_evidences() -> None:
    free = Free(compared(Side(model()), Side(model(PSI, _risen(1, 1.03))), with_tolerances(rig())))
    linear = Linear.about(fit(free)).weighed(free.of.weights)
    wide = np.ones(free.structure_size)
    gained = linear.gained(wide, (4.0, 16.0))
    for n in range(wide.size):
        own = np.where(np.arange(wide.size) == n, 16.0, wide)
        more = linear.evidence(own) - linear.evidence(wide) - 2 * np.log(6 * wide.size)
        assert gained[n, 1] == pytest.approx(more, abs=1e-6)


def test_a_mode_that_rose_alone_is_no_spring() -> None:
    found = diagnose_by_model(model(), model(PSI, _risen(1, 1.03)), rig())
    assert (found.verdict, found.effects) == ("unknown", [])
    assert found.after == found.before


def test_a_change_beside_something_else_is_not_the_answer() -> None:
    """A gain of 1.3, and one mode that rose by 6 %: the gain leaves most of the gap."""
    reference, risen = model(), model(PSI, _risen(2, 1.06))
    constants = risen.modal_constants.copy()
    constants[:, 1] *= 1.3
    found = diagnose_by_model(reference, risen.model_copy(update={"modal_constants": constants}), rig())
    assert (found.verdict, found.effects) == ("unknown", [])
