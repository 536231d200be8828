"""Whether a channel still does what the drive made it do a moment ago; pure functions of samples.

All but `channel_faults` and `tone_is_lost` take one look or many: then looks are the first axis of samples, bases and
results.

While a sine is on, x(t) = c + e(t) Re(A exp(j omega t)) holds from one moment to the next, e the drive's known
envelope: a structure changes its amplitude slowly. It is fitted to an earlier window and compared with a later one.
Where the two part, what the channel does instead says what has become of it: nothing (dead, frozen, unplugged), the
same cut at a level (clipped), or what another channel should do (swapped). A structure does none of these from one
window to the next; that it merely parts, as after a knock on the table, is no fault of the channel.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real

BETTER = 4.0
"""What became of a channel must explain it so many times better than that all is well."""

OVER_NOISE = 3.0
"""A channel is judged where it parts from what was foreseen by so many times its noise at rest."""

OVER_MISFIT = 6.0
"""And by so many times what the earlier window left unexplained: an amplitude that rises or falls along a line parts by
4.7 times that over the windows used here, however fast it does."""

OVER_SIGNAL = 0.02
"""And by this part of its own amplitude."""

STILL = 2.0
MOVING = 8.0
"""A channel is dead that stays within so many times its noise and parts from what was foreseen by more than so many."""

APART = 0.5
"""Or, of a tone that is slow, by this part of it."""

ASTRAY = 10.0
"""A channel has gone astray that parts by so many times its noise and what was left unexplained before."""

DISTINCT = 2.0
"""What is flat is so many times stiller than the same tone on a smaller scale would be."""

LEAST_CUT = 5
CUT_PART = 0.1
"""So many samples, and this part of the window, must lie flat where more was foreseen."""

UNBEATEN = 1.15
"""A weak tone is steady that leaves no more than so many times the noise unexplained."""

LOST_SIGMA = 5.0
"""A weak channel is lost where its power is that of its noise and was to be above it, each by so many deviations."""


@dataclass(frozen=True, eq=False, slots=True)
class PredictedWindow:
    """What an earlier window says of a later one.

    Attributes:
        amplitude: (channels,) of the tone at the full level of the drive.
        phase: (channels,) of the tone, as a complex number of size one.
        misfit: (channels,) rms that the earlier window leaves unexplained.
        level: (channels,) rms of the tone in the earlier window.
        later: (channels, n) foreseen.
    """

    amplitude: Real
    phase: NDArray[np.complex128]
    misfit: Real
    level: Real
    later: Real


def tone_basis(times_s: Real, frequency_hz: float, envelope: Real) -> Real:
    """(n, 3): a constant, and the two quadratures under the drive's envelope."""
    phase = 2 * np.pi * frequency_hz * times_s
    basis = np.empty((len(times_s), 3))
    basis[:, 0] = 1.0
    np.multiply(envelope, np.cos(phase), out=basis[:, 1])
    np.multiply(envelope, np.sin(phase), out=basis[:, 2])
    return basis


def predict_later_window(earlier: Real, earlier_basis: Real, later_basis: Real) -> PredictedWindow:
    """Fit (channels, n) samples by least squares and carry the fit on to a later window."""
    values = np.swapaxes(earlier, -1, -2)
    solved = _least_squares(earlier_basis, values)
    fitted = earlier_basis @ solved
    cosine, sine = solved[..., 1, :], solved[..., 2, :]
    return PredictedWindow(
        amplitude=np.hypot(cosine, sine),
        phase=np.exp(-1j * np.arctan2(sine, cosine)),
        misfit=_rms(values - fitted, axis=-2),
        level=_rms(fitted - solved[..., :1, :], axis=-2),
        later=np.swapaxes(later_basis @ solved, -1, -2),
    )


def _least_squares(basis: Real, values: Real) -> Real:
    """(3, channels) of the (n, 3) basis that are nearest to (n, channels) values."""
    # At size one each, the columns are as good as orthogonal over a period, however low the drive still is.
    size = np.maximum(np.sqrt(np.add.reduce(basis * basis, axis=-2)), np.finfo(float).tiny)
    unit = basis / size[..., None, :]
    across = np.swapaxes(unit, -1, -2)
    try:
        return np.linalg.solve(across @ unit, across @ values) / size[..., None]
    except np.linalg.LinAlgError:
        return np.linalg.pinv(basis) @ values


def departs_from_prediction(seen: Real, foreseen: PredictedWindow, noise: Real) -> NDArray[np.bool_]:
    """(channels,) whether a channel parts from what was foreseen by more than noise and a change of amplitude do."""
    least = np.maximum(OVER_MISFIT * foreseen.misfit, OVER_SIGNAL * np.sqrt(2) * foreseen.level)
    return _rms(seen - foreseen.later, axis=-1) > np.maximum(least, OVER_NOISE * noise)


def channel_faults(seen: Real, foreseen: PredictedWindow, noise: Real, white: Real) -> dict[int, str]:
    """What has become of channels, in words by channel; none for those that follow, or merely part from it.

    Args:
        seen: (channels, n) the later window, all in the same unit.
        foreseen: of it.
        noise: (channels,) rms at rest.
        white: (channels,) the part of it that goes from sample to sample, to which a dead channel falls.
    """
    found: dict[int, str] = {}
    suspects = departs_from_prediction(seen, foreseen, noise)
    if not suspects.any():
        return found
    parted = _rms(seen - foreseen.later, axis=1)
    for channel in np.flatnonzero(suspects):
        top = _cut_at(seen[channel], foreseen.later[channel], float(white[channel]), float(parted[channel]) / BETTER)
        if top is not None:
            found[int(channel)] = f"is cut off at {100 * top:.0f} % of the prediction: clipped"
    for one, other in combinations(range(len(seen)), 2):
        if not suspects[one] and not suspects[other]:
            continue
        pair = [one, other]
        # Two plugs change places: each must read what the other was to read.
        if (_rms(seen[pair] - foreseen.later[pair[::-1]], axis=1) < parted[pair] / BETTER).all():
            found |= {
                int(one): f"and {{{other}}} are exchanged",
                int(other): f"and {{{one}}} are exchanged",
            }
    return found


def tone_is_lost(seen: Real, foreseen: PredictedWindow, white: Real) -> NDArray[np.bool_]:
    """(channels,) whether a weak tone that was to stand above the noise over the later window is gone from it."""
    steady = foreseen.misfit < UNBEATEN * white
    expected = np.hypot(rms_about_line(foreseen.later), white)
    return steady & is_noise_alone(seen, white) & (expected > white * (1 + 3 * _noise_spread(seen)))


def is_noise_alone(seen: Real, white: Real) -> NDArray[np.bool_]:
    """(channels,) whether the power over a window is no more than that of the noise."""
    return rms_about_line(seen) < white * (1 + _noise_spread(seen))


def rms_of_steady_share(seen: Real, foreseen: PredictedWindow) -> Real:
    """(channels,) rms over what was foreseen; where the structure itself beats, it falls in all responses at once."""
    return rms_about_line(seen) / np.maximum(rms_about_line(foreseen.later), 1e-300)


def is_dead(seen: Real, foreseen: PredictedWindow, white: Real) -> NDArray[np.bool_]:
    """(channels,) whether a channel stays within its noise where it was to move far beyond it."""
    still = rms_about_line(seen) < STILL * white
    if not still.any():
        return still
    # In a low tone a whole window may lie near a straight line: then it must be far from where it was to be.
    least = np.maximum(np.maximum(MOVING * white, OVER_MISFIT * foreseen.misfit), APART * foreseen.level)
    moving = (rms_about_line(foreseen.later) > MOVING * white) | (_rms(seen - foreseen.later, axis=-1) > least)
    return still & moving


def departs_from_drive(seen: Real, foreseen: PredictedWindow, noise: Real) -> NDArray[np.bool_]:
    """(channels,) whether what followed the drive well parts from what was foreseen by as much as it moved."""
    least = np.maximum.reduce([ASTRAY * noise, ASTRAY * foreseen.misfit, foreseen.level])
    return _rms(seen - foreseen.later, axis=1) > least


def rms_about_line(values: Real) -> Real:
    """(channels,) rms about a straight line: what is left of a channel that decays or drifts, but does not move."""
    line = _straight_line_basis(values.shape[-1])
    return _rms(values - (values @ line.T) @ line, axis=-1)


@lru_cache
def _straight_line_basis(n: int) -> Real:
    """(2, n) an orthonormal basis of the straight lines over n samples."""
    ramp = np.arange(n) - (n - 1) / 2
    return np.array([np.full(n, n**-0.5), ramp / max(float(np.linalg.norm(ramp)), 1.0)])


def _cut_at(own: Real, later: Real, white: float, at_most: float) -> float | None:
    """The part of what was foreseen at which a channel is cut off flat; None if it is not."""
    top = float(np.abs(own).max())
    above = np.abs(later) > top
    if above.sum() < max(LEAST_CUT, CUT_PART * own.size) or _rms(own - np.clip(later, -top, top), axis=0) >= at_most:
        return None
    part = top / float(np.abs(later).max())
    # A tone that is merely smaller, as where two of the structure cancel, spreads so much: in noise it may seem flat.
    if part * np.abs(later[above]).std() < DISTINCT * STILL * white:
        return None
    return part if np.abs(own[above]).std() < STILL * white else None


def _noise_spread(seen: Real) -> float:
    return LOST_SIGMA / float(np.sqrt(2 * seen.shape[-1]))


def _rms(values: Real, axis: int) -> Real:
    return np.sqrt(np.add.reduce(values * values, axis=axis) / values.shape[axis])
