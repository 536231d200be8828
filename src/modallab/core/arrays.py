"""What arrays hold, as types."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]
Complex128 = NDArray[np.complex128]
