"""Complex lines as rows of real numbers, and back."""

import numpy as np
from numpy.typing import NDArray


def real_rows(values: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Complex (..., lines) to real (2 lines, ...), the same least-squares problem in real numbers.

    Each line's real part stands above its imaginary part, as they lie in memory: hundreds of FRFs are not copied.
    """
    lies = values.dtype == np.complex128 and values.strides[-1] == values.itemsize
    return np.moveaxis((values if lies else np.ascontiguousarray(values, np.complex128)).view(np.float64), -1, 0)


def stack_lines(values: NDArray[np.complex128]) -> NDArray[np.float64]:
    """The same of complex (lines, ...), where the lines come first: (2 lines, ...)."""
    return np.stack([values.real, values.imag], axis=1).reshape(-1, *values.shape[1:])


def complex_lines(rows: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Real (2 lines, ...) back to complex (..., lines)."""
    return np.ascontiguousarray(np.moveaxis(rows, 0, -1)).view(np.complex128)
