"""Modes before and after a change, and the change that a wanted property needs, as tables: the same at every door."""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from modallab.core.digits import list_in_words, number_with_sigma, significant_digits, to_places_of_sigma
from modallab.core.errors import StorageError
from modallab.core.model import ModalModel
from modallab.core.rig import Tolerance
from modallab.formats.atomic import replacing
from modallab.modification.free_band import FreeBand
from modallab.modification.inverse import BestAbsorber, By, ChangeAtPoint
from modallab.modification.known import KnownStructure
from modallab.modification.modified import ModesAfter
from modallab.modification.structure import At

SAME = 0.5
"""MAC above which a mode after a change is called by the number of the one before."""
FARTHEST = 1.2
"""Ratio of two frequencies from which they are of different modes."""
TWO_SIDED = 1.96
TRUSTED = 0.1
"""A larger part of a shift by what lies outside the band is said beneath the table, and more of a joint's forces."""
_UNITS: dict[By, str] = {"mass": "kg", "spring": "N/m"}


class TableRows(NamedTuple):
    """A table: headings, rows of words, and what is to be said beneath it."""

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str


HEADINGS = ("mode", "before [Hz]", "after [Hz]", "shift [%]", "damping before [%]", "damping after [%]")


def modified_rows(known: KnownStructure, changes: Sequence[str]) -> TableRows:
    """Each mode after the change, with one standard deviation, beside the one before whose shape is most like it."""
    before, after = known.model, known.modes
    rows = tuple(_mode_row(before, after, r) for r in range(len(after.frequency_hz)))
    return TableRows(HEADINGS, rows, " ".join([f"{'; '.join(changes)}.", *notes_of(known)]))


def _mode_row(before: ModalModel, after: ModesAfter, r: int) -> tuple[str, ...]:
    hz = number_with_sigma(float(after.frequency_hz[r]), float(after.frequency_sigma_hz[r]))
    damping = number_with_sigma(100 * float(after.damping_ratio[r]), 100 * float(after.damping_sigma[r]))
    if after.mac[r] < SAME:
        return (str(r + 1), "new", hz, "", "", damping)
    q = int(after.like[r])
    was, zeta = float(before.frequency_hz[q]), 100 * float(before.damping_ratio[q])
    shift = 100 * (float(after.frequency_hz[r]) / was - 1), 100 * float(after.frequency_sigma_hz[r]) / was
    return (
        str(r + 1),
        number_with_sigma(was, float(before.frequency_sigma_hz[q])),
        hz,
        number_with_sigma(*shift),
        number_with_sigma(zeta, 100 * float(before.damping_sigma[q])),
        damping,
    )


def notes_of(known: KnownStructure) -> list[str]:
    """What the table cannot be trusted for, and why."""
    before, after = known.model, known.modes
    sentences = ["One sigma of the model, of sensitivities and of places.", *_joint_note(known)]
    shift = np.abs(after.frequency_hz / before.frequency_hz[after.like] - 1)
    doubtful = [str(r + 1) for r in np.flatnonzero(after.outside > TRUSTED * np.maximum(shift, 1e-4))]
    if doubtful:
        most, band = 100 * float(after.outside.max()), f"{before.band_hz[0]:.4g} to {before.band_hz[1]:.4g} Hz"
        which = f"mode{'s' if len(doubtful) > 1 else ''} {list_in_words(doubtful)}"
        sentences.append(
            f"More than a tenth of the shift of {which} comes from modes outside {band}, up to"
            f" {most:.2g} % of the frequency: only a test of a wider band shows it better."
        )
    if after.hidden:
        sentences.append("What moved beyond the band is left out.")
    return sentences


def _joint_note(known: KnownStructure) -> list[str]:
    if known.conditioning is None:
        return []
    tolerance = Tolerance.usual() if known.rig is None else known.rig.tolerance
    one, grown = 100 * tolerance.sensitivity, 100 * tolerance.sensitivity * known.conditioning
    said = f"An error of {one:.2g} % of the receptances at the joint is one of {grown:.2g} % of its forces."
    if grown <= 100 * TRUSTED:
        return [said]
    return [said, "Do not use the result: there, one structure alone says nearly all of how both move."]


class PredictedMode(NamedTuple):
    """A mode that was predicted and measured: both in Hz, whether they agree, and that in words."""

    mode: int
    predicted_hz: float
    sigma_hz: float
    measured_hz: float
    inside: bool
    words: str


def check_predictions(after: ModesAfter, measured: ModalModel) -> list[PredictedMode]:
    """Each predicted mode beside the nearest one that was measured with the changes."""
    apart = np.abs(np.log(after.frequency_hz[:, None] / measured.frequency_hz))
    rows, columns = linear_sum_assignment(apart)
    return [
        _check_mode(after, measured, int(r), int(m))
        for r, m in zip(rows, columns, strict=True)
        if apart[r, m] < np.log(FARTHEST)
    ]


def _check_mode(after: ModesAfter, measured: ModalModel, r: int, m: int) -> PredictedMode:
    hz, sigma = float(after.frequency_hz[r]), float(after.frequency_sigma_hz[r])
    found, own = float(measured.frequency_hz[m]), float(np.nan_to_num(measured.frequency_sigma_hz[m]))
    inside = bool(abs(found - hz) <= TWO_SIDED * np.hypot(sigma, own))
    said = (
        f"Mode {r + 1}: predicted {number_with_sigma(hz, sigma)} Hz, measured "
        f"{to_places_of_sigma(found, sigma / 10)} Hz"
    )
    return PredictedMode(r + 1, hz, sigma, found, inside, said if inside else f"{said}, outside the 95 % interval")


def write_rows(path: Path, rows: TableRows) -> Path:
    """Write a table as a CSV file; returns the path.

    Raises:
        StorageError: the name ends otherwise, or the file cannot be written.
    """
    if path.suffix != ".csv":
        raise StorageError(f"{path.name} does not end with .csv", where=str(path), remedy="name it modes.csv")
    with replacing(path) as draft, draft.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([rows.headings, *rows.rows])
    return path


def _point_of(at: At) -> str:
    """A place as tables call it."""
    return str(at[0] if isinstance(at, tuple) else at)


def tuned_rows(answers: Sequence[ChangeAtPoint], by: By, mode: int, to_hz: float) -> TableRows:
    """What brings a mode to a frequency at each point, the smallest first; beside each what is in reach there."""
    rows = tuple(
        (
            _point_of(a.at),
            number_with_sigma(a.size, a.sigma) if a.feasible else "none",
            number_with_sigma(to_hz, a.hz_sigma) if a.feasible else "",
            f"{a.lowest_hz:.5g} to {a.highest_hz:.5g}",
        )
        for a in answers
    )
    feasible = sum(a.feasible for a in answers)
    how = "No point has" if not feasible else f"{feasible} of {len(answers)} points have"
    sentences = f"{how} a {by} that brings mode {mode} to {to_hz:g} Hz; beside each, where any {by} can bring it."
    return TableRows(("point", f"{by} [{_UNITS[by]}]", "gives [Hz]", "in reach [Hz]"), rows, sentences)


def free_rows(answers: Sequence[FreeBand], by: By, band_hz: tuple[float, float]) -> TableRows:
    """What leaves no mode in a band at each point, the smallest first; or the mode that stays there."""
    rows = tuple((_point_of(a.at), *_size_and_limit(a, by)) for a in answers)
    feasible = sum(a.feasible for a in answers)
    how = "No point has" if not feasible else f"{feasible} of {len(answers)} points have"
    edge = f"{band_hz[0]:g} to {band_hz[1]:g} Hz"
    sentences = f"{how} a {by} that leaves no mode from {edge}. There a mode is at the edge: take two sigma more."
    return TableRows(("point", f"{by} [{_UNITS[by]}]", "free up to"), rows, sentences)


def _size_and_limit(a: FreeBand, by: By) -> tuple[str, str]:
    if not a.feasible:
        return "none", f"mode {a.stays} stays, at {a.stays_hz:.5g} Hz"
    limit = f"{a.up_to:.3g} {_UNITS[by]}" if a.up_to < float("inf") else "any size"
    return (number_with_sigma(a.size, a.sigma) if a.size else "0: free already"), limit


def absorber_rows(found: BestAbsorber, mode: int) -> TableRows:
    """The absorber, and the largest mobility at its point without and with it."""
    a = found.absorber
    row = (
        _point_of(a.at),
        f"{a.mass:.4g}",
        f"{a.frequency_hz:.5g}",
        f"{100 * a.damping_ratio:.4g}",
        number_with_sigma(found.before, found.before_sigma),
        number_with_sigma(found.after, found.after_sigma),
    )
    names = ("point", "mass [kg]", "frequency [Hz]", "damping [%]", "peak without [m/(N s)]", "peak with [m/(N s)]")
    share = f"It is {significant_digits(100 * found.mass_ratio, 2)} % of the modal mass there."
    return TableRows(names, (row,), f"The absorber of this mass that leaves the least peak about mode {mode}. {share}")
