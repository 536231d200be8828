"""What no kind of change explains is unknown, and is worded like any other answer."""

import numpy as np
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
