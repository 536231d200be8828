"""How well poles are known by how they differ between parts of a test.

The fit's sigma takes the errors of the lines for independent. Those of an FRF of one random record are not: its leakage
and what the local polynomials miss reach over many lines, and differ from one stretch of the record to the next. So
stretches are fitted apart, from the same poles, and the sigma of the whole is at least that of their mean.
"""

from collections.abc import Sequence

import numpy as np
from scipy.special import ndtri, stdtrit

from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.identification.likelihood.basis import poles_of
from modallab.identification.likelihood.frf_fit import fit_frf

PARTS = 4
STEPS = 12


def with_repeatability_sigmas(model: ModalModel, parts: Sequence[Frf]) -> ModalModel:
    """The model, its sigmas of frequency and damping no less than the scatter of the parts says.

    Of few parts the scatter is known roughly, which Student's factor allows for.

    Args:
        model: of the whole test.
        parts: FRFs of stretches of it, of one length, in the model's band.
    """
    if len(parts) < 2:
        return model
    poles = poles_of(2 * np.pi * model.frequency_hz, model.damping_ratio)
    try:
        fits = [fit_frf(part, poles, STEPS).point.parameters for part in parts]
    except IdentificationError:
        return model
    student = stdtrit(len(parts) - 1, 0.975) / ndtri(0.975)
    n = poles.size
    f, zeta = (
        student * np.std([values], axis=1, ddof=1)[0] / np.sqrt(len(parts))
        for values in ([p.omega[:n] / (2 * np.pi) for p in fits], [p.zeta[:n] for p in fits])
    )
    wider = np.maximum(f, model.frequency_sigma_hz), np.maximum(zeta, model.damping_sigma)
    return model.model_copy(update={"frequency_sigma_hz": wider[0], "damping_sigma": wider[1]})
