"""The free numbers of a fit, read back from what its document says of the twin."""

from math import log

import numpy as np
from numpy.typing import NDArray

from modallab.core.diagnosis import Calibrated
from modallab.gap.model.nuisances import Nuisances, beam_of
from modallab.gap.model.tolerances import FREE, MOST
from modallab.twin.structure import ROOT, believed_root

Array = NDArray[np.float64]


def coordinates_of(twin: Calibrated, free: Nuisances) -> Array:
    """(size,) the nuisances at which a fit left the twin: what `calibrated` wrote down, the other way round.

    Args:
        twin: the numbers.
        free: the nuisances, which may be of another campaign of the same rig: what the document does not mention, such
            as where the hits at a new point land, is 0.
    """
    rig, u = free.rig, np.zeros(free.size)
    beam, t = beam_of(rig), rig.tolerance
    own = (
        (twin.youngs_modulus_pa / beam.youngs_modulus_pa, t.youngs_modulus),
        (twin.thickness_m / beam.thickness_m, t.thickness),
        (twin.density_kg_m3 / beam.density_kg_m3, t.density),
    )
    u[:3] = [_free(log(ratio) / sigma) if sigma else 0.0 for ratio, sigma in own]
    zeta = np.array(twin.zeta[: free.modes]) / rig.damping_ratio.guess
    u[3 : 3 + free.modes] = np.log(zeta) / log(rig.damping_ratio.factor)
    for k, channel in enumerate(free.gains):
        u[3 + free.modes + k] = _free(log(twin.gains.get(channel, 1.0)) / free.tolerance)
    told = {(d.tolerance, d.at): d.u for d in twin.departures}
    u[free.first_deviation : free.first_deviation + len(free.deviations)] = [
        told.get((d.tolerance, d.at), 0.0) for d in free.deviations
    ]
    if free.root:
        u[-2] = _free(log(twin.root_rotation / believed_root(beam)) / ROOT)
    u[-1] = 0.5 + _free(twin.residual_compliance - 0.5, 0.6, 1.0)
    return u


def _free(value: float, free: float = FREE, most: float = MOST) -> float:
    """The inverse of `held_one`: what was pressed together towards its bound, as it was."""
    if abs(value) < free:
        return value
    room = most - free
    return float(np.sign(value) * (free + room * np.arctanh(min((abs(value) - free) / room, 1 - 1e-9))))
