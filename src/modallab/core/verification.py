"""The identified model compared with the measurement."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.frf import Frf


@dataclass(frozen=True, eq=False, slots=True)
class Verification:
    """Measured against regenerated mobility, both through the same block.

    Attributes:
        measured: mobility from the test's blocks.
        regenerated: mobility of the model's response to the measured force, cut as the blocks were.
        untruncated: the model's own mobility on a fine grid, with no block at all.
        frac: (outputs, inputs) FRAC of measured against regenerated; of FRFs as imported in the quantity they came in.
    """

    measured: Frf
    regenerated: Frf
    untruncated: Frf
    frac: NDArray[np.float64]
