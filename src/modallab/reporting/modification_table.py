"""Models changed, or corrected by a test, as tables: the same words at every door."""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from modallab.core.digits import list_in_words, number_with_sigma, rounded_to_sigma, significant_digits
from modallab.core.documents.model_change import CheckedMode
from modallab.core.documents.model_update import ParameterView, UpdatedModelView
from modallab.core.errors import StorageError
from modallab.core.model import ModalModel
from modallab.core.rig import Tolerance
from modallab.formats.atomic import replacing
from modallab.modification.inverse import BestAbsorber, By, ChangeAtPoint, FreeBand
from modallab.modification.known import KnownStructure
from modallab.modification.modified import ModifiedModes
from modallab.modification.structure import At
from modallab.updating.result import Prior, UpdatedParameters

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


def _mode_row(before: ModalModel, after: ModifiedModes, r: int) -> tuple[str, ...]:
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
    sentences = ["Deviations are one sigma, from model, sensitivities and places.", *_joint_note(known)]
    shift = np.abs(after.frequency_hz / before.frequency_hz[after.like] - 1)
    doubtful = [str(r + 1) for r in np.flatnonzero(after.outside > TRUSTED * np.maximum(shift, 1e-4))]
    if doubtful:
        most, band = 100 * float(after.outside.max()), f"{before.band_hz[0]:.4g} to {before.band_hz[1]:.4g} Hz"
        which = f"mode{'s' if len(doubtful) > 1 else ''} {list_in_words(doubtful)}"
        sentences.append(
            f"More than a tenth of the shift of {which} comes from modes outside {band}, up to"
            f" {most:.2g} % of the frequency: only a test of a wider band improves this."
        )
    if after.hidden:
        sentences.append("Modes moved out of the band are left out.")
    return sentences


def _joint_note(known: KnownStructure) -> list[str]:
    if known.conditioning is None:
        return []
    tolerance = Tolerance.usual() if known.rig is None else known.rig.tolerance
    one, grown = 100 * tolerance.sensitivity, 100 * tolerance.sensitivity * known.conditioning
    said = f"An error of {one:.2g} % of the receptances at the joint is one of {grown:.2g} % of its forces."
    if grown <= 100 * TRUSTED:
        return [said]
    return [said, "Do not use the result: one structure alone determines nearly all of the joint's motion."]


def check_predictions(after: ModifiedModes, measured: ModalModel) -> list[CheckedMode]:
    """Each predicted mode beside the nearest one that was measured with the changes."""
    apart = np.abs(np.log(after.frequency_hz[:, None] / measured.frequency_hz))
    rows, columns = linear_sum_assignment(apart)
    return [
        _check_mode(after, measured, int(r), int(m))
        for r, m in zip(rows, columns, strict=True)
        if apart[r, m] < np.log(FARTHEST)
    ]


def _check_mode(after: ModifiedModes, measured: ModalModel, r: int, m: int) -> CheckedMode:
    hz, sigma = float(after.frequency_hz[r]), float(after.frequency_sigma_hz[r])
    found, own = float(measured.frequency_hz[m]), float(np.nan_to_num(measured.frequency_sigma_hz[m]))
    inside = bool(abs(found - hz) <= TWO_SIDED * np.hypot(sigma, own))
    said = (
        f"Mode {r + 1}: predicted {number_with_sigma(hz, sigma)} Hz, measured {rounded_to_sigma(found, sigma / 10)} Hz"
    )
    words = said if inside else f"{said}, outside the 95 % interval"
    return CheckedMode(
        mode=r + 1, predicted_hz=hz, predicted_sigma_hz=sigma, measured_hz=found, inside=inside, words=words
    )


def write_rows(path: Path, rows: TableRows) -> Path:
    """Write a table as a CSV file; returns the path.

    Raises:
        StorageError: the file name has another ending, or the file cannot be written.
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
    sentences = f"{how} a {by} that brings mode {mode} to {to_hz:g} Hz; beside each, the range that any {by} can reach."
    return TableRows(("point", f"{by} [{_UNITS[by]}]", "gives [Hz]", "in reach [Hz]"), rows, sentences)


def free_rows(answers: Sequence[FreeBand], by: By, band_hz: tuple[float, float]) -> TableRows:
    """What leaves no mode in a band at each point, the smallest first; or the mode that stays there."""
    rows = tuple((_point_of(a.at), *_size_and_limit(a, by)) for a in answers)
    feasible = sum(a.feasible for a in answers)
    how = "No point has" if not feasible else f"{feasible} of {len(answers)} points have"
    edge = f"{band_hz[0]:g} to {band_hz[1]:g} Hz"
    sentences = f"{how} a {by} that leaves no mode from {edge}. With these a mode is at the edge: add two sigma."
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
    share = f"This mass is {significant_digits(100 * found.mass_ratio, 2)} % of the modal mass there."
    return TableRows(names, (row,), f"The absorber of this mass with the smallest peak about mode {mode}. {share}")


def parameter_rows(found: UpdatedParameters) -> TableRows:
    """Each parameter as it was believed and as it was found, with its 95 % interval."""
    rows = tuple(_parameter_row(found, name) for name in found.numbers)
    return TableRows(
        ("parameter", "believed", "found", "95 % interval", "determined"), rows, " ".join(_notes_on_parameters(found))
    )


def _parameter_row(found: UpdatedParameters, name: str) -> tuple[str, ...]:
    prior = found.priors[name]
    size, unit = (1e-9, "GPa") if prior.unit == "Pa" else (1.0, prior.unit)
    sigma = prior.sigma * prior.value if prior.relative else prior.sigma
    low, high, value = (_value_and_prior(v * size, prior) for v in (*found.interval[name], found.numbers[name]))
    determined = "no" if name in found.undetermined_parameters else "yes"
    title = f"{name} [{unit}]" if unit else name
    return title, number_with_sigma(size * prior.value, size * sigma), value, f"{low} to {high}", determined


def _value_and_prior(value: float, prior: Prior) -> str:
    return significant_digits(value, 5 if prior.value else 3)


def _notes_on_parameters(found: UpdatedParameters) -> list[str]:
    hz, shapes = found.off
    sentences = [
        f"With these parameters the model's frequencies are off by about {100 * hz:.2g} %, its shapes by "
        f"{100 * shapes:.2g} %."
    ]
    if found.undetermined_parameters:
        sentences.append(f"The test adds little to the prior of {list_in_words(list(found.undetermined_parameters))}.")
    sentences += [f"Only a combination of {a} and {b} is known." for a, b in found.correlated_pairs]
    if found.held_out:
        before, after = (100 * e for e in found.rms_error(found.held_out))
        modes = list_in_words([str(r) for r in found.held_out])
        sentences.append(f"Held out, mode {modes}: frequency off by {before:.2g} % before, by {after:.2g} % after.")
    return sentences


def updated_mode_rows(found: UpdatedParameters) -> TableRows:
    """Each measured mode beside the model's, before and after."""
    before, after = found.errors
    rows = tuple(
        (
            str(r + 1),
            number_with_sigma(float(hz), float(found.measured_sigma_hz[r])),
            f"{100 * before[r]:+.3g}",
            f"{100 * after[r]:+.3g}",
            f"{found.before.mac[r]:.3f}",
            f"{found.after.mac[r]:.3f}",
            "held out" if r + 1 in found.held_out else "",
        )
        for r, hz in enumerate(found.measured_hz)
    )
    headings = ("mode", "measured [Hz]", "before [%]", "after [%]", "MAC before", "MAC after", "")
    return TableRows(headings, rows, "Frequencies of the model over the measured ones.")


def updated_document(found: UpdatedParameters) -> UpdatedModelView:
    """All numbers, as a document."""
    parameters = {
        name: ParameterView(
            believed=prior.value,
            found=found.numbers[name],
            interval=(found.interval[name][0], found.interval[name][1]),
            unit=prior.unit,
            determined=name not in found.undetermined_parameters,
        )
        for name, prior in found.priors.items()
    }
    return UpdatedModelView(
        parameters=parameters,
        together=found.correlated_pairs,
        held_out=found.held_out,
        measured_hz=found.measured_hz,
        before_hz=found.before.frequency_hz,
        after_hz=found.after.frequency_hz,
        mac_before=found.before.mac,
        mac_after=found.after.mac,
        notes=tuple(_notes_on_parameters(found)),
    )
