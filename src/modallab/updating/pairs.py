"""Which predicted mode is which measured one."""

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from modallab.core.errors import DataError
from modallab.identification.selection.criteria import mac
from modallab.updating.data import ModeData

Real = NDArray[np.float64]


def paired(data: ModeData, frequency_hz: Real, shapes: Real) -> tuple[NDArray[np.int64], Real]:
    """Place of the predicted mode of each measured one, and its sign.

    Few points make shapes alike whose frequencies lie far apart: the MAC counts less by the ratio of frequencies.

    Raises:
        DataError: the model has fewer modes than were measured.
    """
    if frequency_hz.size < data.modes:
        raise DataError(
            f"the model has {frequency_hz.size} modes, and {data.modes} were measured", remedy="compute more modes"
        )
    apart = np.abs(np.log(frequency_hz / data.frequency_hz[:, None]))
    _, places = linear_sum_assignment(-mac(data.shapes, shapes) * np.exp(-apart))
    signs = np.sign(np.sum(shapes[places] * data.shapes, axis=1))
    return places, np.where(signs == 0, 1.0, signs)
