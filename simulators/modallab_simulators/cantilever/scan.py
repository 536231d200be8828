"""The recursion z[k+1] = lambda z[k] + w[k] of many first-order poles at once, without a loop over samples."""

import numpy as np

from modallab.core.arrays import Complex128

_MAX_LOG = 300.0


class Scan:
    """Runs `length` steps from a start value.

    With powers of lambda taken out, the recursion is a running sum. Its rounding is that of the largest state on the
    way, since older terms only shrink; the stretch is cut where the powers would leave double precision's range.
    """

    def __init__(self, poles: Complex128, step_s: float, length: int) -> None:
        decay = float(np.max(-poles.real, initial=0.0)) * step_s
        self._stretch = length if decay * length < _MAX_LOG else max(1, int(_MAX_LOG / decay))
        self._length = length
        self._decays: Complex128 = np.exp(np.multiply.outer(np.arange(length + 1) * step_s, poles))
        self._grows: Complex128 = np.exp(np.multiply.outer(-np.arange(1, self._stretch + 1) * step_s, poles))

    def free(self, start: Complex128) -> tuple[Complex128, Complex128]:
        """States of an undriven stretch, (length, poles), and the state after it."""
        return self._decays[:-1] * start, self._decays[-1] * start

    def driven(self, start: Complex128, driving: Complex128) -> tuple[Complex128, Complex128]:
        """States of a stretch driven by w, (length, poles), and the state after it."""
        states = np.empty_like(driving)
        for first in range(0, self._length, self._stretch):
            part = driving[first : first + self._stretch]
            count = len(part)
            sums = part * self._grows[:count]
            np.cumsum(sums, axis=0, out=sums)
            sums += start
            states[first] = start
            np.multiply(sums[:-1], self._decays[1:count], out=states[first + 1 : first + count])
            start = sums[-1] * self._decays[count]
        return states, start
