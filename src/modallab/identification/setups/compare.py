"""Whether the structure was the same in every set-up: frequencies, and what the reference reads."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.identification.setups.found import SetUpModel

Entry = tuple[int, int]

OFF_SIGMAS = 4.0
"""Beyond so many sigmas two set-ups differ: of dozens of comparisons none is this far off by chance."""
OFF_SHIFT = 1e-4
"""Relative. What is less is not said: one kelvin moves the frequencies of steel by as much."""
OFF_RATIO = 0.02
"""The same of what the reference reads: no two series of hits land and slant alike to better than this."""


@dataclass(frozen=True, eq=False, slots=True)
class ComparedSetUp:
    """One set-up compared with the one that the others are compared with.

    Attributes:
        name: of the set-up.
        against: name of the other; of itself for that one.
        frequency_hz: (modes,)
        shift: (modes,) relative, of the frequency.
        shift_sigma: (modes,)
        ratio: (modes,) of what the reference reads, 1 where both agree; NaN where nothing is common to both.
        ratio_sigma: (modes,)
        moved: names of the sensors that stand elsewhere.
        moved_kg: their mass.
        stays: whether a sensor stands at one and the same point in both.
    """

    name: str
    against: str
    frequency_hz: Real
    shift: Real
    shift_sigma: Real
    ratio: Real
    ratio_sigma: Real
    moved: tuple[str, ...]
    moved_kg: float
    stays: bool

    @property
    def shift_sigmas(self) -> Real:
        """(modes,) the shift in its own sigmas."""
        return self.shift / self.shift_sigma

    @property
    def ratio_sigmas(self) -> Real:
        """(modes,) how far the ratio is from 1, in its own sigmas."""
        return (self.ratio - 1) / self.ratio_sigma

    @property
    def off(self) -> bool:
        """Whether a frequency or the reference differs by more than chance."""
        return bool(np.any(self.shift_off) or np.any(self.ratio_off))

    @property
    def shift_off(self) -> NDArray[np.bool_]:
        """(modes,) whose frequencies differ."""
        return _differs_by_more_than_chance(self.shift, self.shift_sigma, OFF_SHIFT)

    @property
    def ratio_off(self) -> NDArray[np.bool_]:
        """(modes,) which the reference reads otherwise."""
        return _differs_by_more_than_chance(self.ratio - 1, self.ratio_sigma, OFF_RATIO)

    def words(self) -> tuple[str, ...]:
        """A sentence on the mode that differs most, by frequency and by the reference; or that none does."""
        shift, ratio = np.where(self.shift_off, np.abs(self.shift), 0), np.where(self.ratio_off, self.ratio - 1, 0)
        said = [self._of_shift(int(np.argmax(shift)))] if shift.any() else []
        said += [self._of_ratio(int(np.argmax(np.abs(ratio))))] if ratio.any() else []
        return tuple(said) or (f"set-up {self.name}: agrees with {self.against}",)

    def _of_shift(self, r: int) -> str:
        percent, sigmas = 100 * self.shift[r], abs(self.shift_sigmas[r])
        side = "lower" if percent < 0 else "higher"
        return (
            f"set-up {self.name}: mode {r + 1} is {abs(percent):.2g} % {side} than in {self.against}"
            f" ({sigmas:.0f} sigmas){_others_differ(self.shift_off)}: {self._cause()}"
        )

    def _cause(self) -> str:
        if self.moved_kg > 0:
            return f"the mass of {', '.join(self.moved)} ({1000 * self.moved_kg:.3g} g) moved"
        moved = f"the mass of {', '.join(self.moved)} moved (the rig file states none), or " if self.moved else ""
        return f"{moved}the structure, its clamp or its temperature changed"

    def _of_ratio(self, r: int) -> str:
        percent, sigmas = 100 * (self.ratio[r] - 1), abs(self.ratio_sigmas[r])
        return (
            f"set-up {self.name}: the reference reads mode {r + 1} {percent:+.2g} % against {self.against}"
            f" ({sigmas:.0f} sigmas){_others_differ(self.ratio_off)}:"
            " its sensor, the hammer's gain, or the mode's shape changed"
        )


def _others_differ(off: NDArray[np.bool_]) -> str:
    return f", and {off.sum() - 1} more modes differ" if off.sum() > 1 else ""


def _differs_by_more_than_chance(off: Real, sigma: Real, least: float) -> NDArray[np.bool_]:
    # What has no sigma, or nothing to be compared with, differs from nothing.
    return (np.abs(off) > least) & (np.abs(off) > OFF_SIGMAS * sigma)


def compare_setups(found: Sequence[SetUpModel], modes: NDArray[np.int64]) -> tuple[ComparedSetUp, ...]:
    """Every set-up against the one in the middle of them by frequency; of two, against the first.

    Args:
        found: at least two set-ups.
        modes: (set-ups, modes) places of the same modes, as `same_modes`.
    """
    middle = _middle_setup(found, modes)
    return tuple(_compare_setup(found[n], modes[n], found[middle], modes[middle]) for n in range(len(found)))


def _middle_setup(found: Sequence[SetUpModel], modes: NDArray[np.int64]) -> int:
    """The set-up that is off the medians least: one that is off among three or more is then named itself."""
    if len(found) < 3:
        return 0
    frequency = np.array([item.model.frequency_hz[at] for item, at in zip(found, modes, strict=True)])
    return int(np.argmin(np.abs(frequency / np.median(frequency, axis=0) - 1).sum(axis=1)))


def _compare_setup(
    one: SetUpModel, at: NDArray[np.int64], other: SetUpModel, there: NDArray[np.int64]
) -> ComparedSetUp:
    f, g = one.model.frequency_hz[at], other.model.frequency_hz[there]
    sigma = np.hypot(one.model.frequency_sigma_hz[at], other.model.frequency_sigma_hz[there])
    ratio, ratio_sigma = reference_ratio(one, at, other, there)
    places = other.standing
    moved = [n for n, (name, point) in enumerate(one.standing.items()) if places.get(name) != point]
    return ComparedSetUp(
        name=one.name,
        against=other.name,
        frequency_hz=f,
        shift=f / g - 1,
        shift_sigma=sigma / g,
        ratio=ratio,
        ratio_sigma=ratio_sigma,
        moved=tuple(one.model.outputs[n] for n in moved),
        moved_kg=sum(one.masses_kg[n] for n in moved),
        stays=len(moved) < len(one.model.outputs),
    )


def reference_ratio(
    one: SetUpModel, at: NDArray[np.int64], other: SetUpModel, there: NDArray[np.int64]
) -> tuple[Real, Real]:
    """(modes,) amplitude in one set-up over that in the other, by what is common to both, and its sigma.

    Least squares over the modal constants of the reference, weighted by their sigmas: the real factor c of
    A_one = c A_other. NaN where nothing is common, or in a set-up against itself.
    """
    pairs = common_entries(one, other)
    if not pairs or one is other:
        return np.full(at.size, np.nan), np.full(at.size, np.nan)
    ours, theirs = (tuple(np.array(side).T) for side in zip(*pairs, strict=True))
    a, b = one.model.modal_constants[at][:, *ours], other.model.modal_constants[there][:, *theirs]
    s, t = one.model.modal_constant_sigma[at][:, *ours], other.model.modal_constant_sigma[there][:, *theirs]
    weight = 1 / (s**2 + t**2)
    power = np.sum(weight * np.abs(b) ** 2, axis=1)
    # The sigmas are of complex numbers; a real factor sees one of their two parts.
    return np.sum(weight * (b.conj() * a).real, axis=1) / power, np.sqrt(0.5 / power)


def common_entries(one: SetUpModel, other: SetUpModel) -> list[tuple[Entry, Entry]]:
    """(output, input) of one set-up and of the other that are the same FRF.

    Sensors that stay, with the same strike point; where none does, another sensor at the same point; where no point
    is shared either, output and input exchanged.
    """
    rows = list(zip(one.model.outputs, one.model.output_points, strict=True))
    cols = list(zip(other.model.outputs, other.model.output_points, strict=True))
    stay = [(i, j) for i, row in enumerate(rows) for j, col in enumerate(cols) if row == col and row[1] is not None]
    shared = [(i, j) for i, row in enumerate(rows) for j, col in enumerate(cols) if row[1] == col[1] is not None]
    struck = {p: k for k, p in enumerate(other.model.input_points) if p is not None}
    same = [(k, struck[p]) for k, p in enumerate(one.model.input_points) if p in struck]
    direct = [((i, k), (j, m)) for i, j in (stay or shared) for k, m in same]
    return direct or _exchanged_modes(one, other)


def _exchanged_modes(one: SetUpModel, other: SetUpModel) -> list[tuple[Entry, Entry]]:
    places = {p: j for j, p in enumerate(other.model.output_points) if p is not None}
    struck = {p: k for k, p in enumerate(other.model.input_points) if p is not None}
    return [
        ((i, k), (places[q], struck[p]))
        for i, p in enumerate(one.model.output_points)
        for k, q in enumerate(one.model.input_points)
        if p in struck and q in places
    ]
