"""What no kind of change explains is unknown, and is worded like any other answer."""

import numpy as np
import pytest
from phased_line import OMEGA, PSI, model, rig

from modallab.gap.modal.diagnosis import diagnose_by_model


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
