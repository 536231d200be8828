"""The change that a wanted property needs, as a table: the same words at every door."""

from collections.abc import Sequence

from modallab.core.digits import number_with_sigma, significant_digits
from modallab.modification.free_band import FreeBand
from modallab.modification.inverse import BestAbsorber, By, ChangeAtPoint
from modallab.modification.structure import At
from modallab.reporting.modified_table import TableRows

UNITS: dict[By, str] = {"mass": "kg", "spring": "N/m"}


def point_of(at: At) -> str:
    """A place as tables call it."""
    return str(at[0] if isinstance(at, tuple) else at)


def tuned_rows(answers: Sequence[ChangeAtPoint], by: By, mode: int, to_hz: float) -> TableRows:
    """What brings a mode to a frequency at each point, the smallest first; beside each what is in reach there."""
    rows = tuple(
        (
            point_of(a.at),
            number_with_sigma(a.size, a.sigma) if a.feasible else "none",
            number_with_sigma(to_hz, a.hz_sigma) if a.feasible else "",
            f"{a.lowest_hz:.5g} to {a.highest_hz:.5g}",
        )
        for a in answers
    )
    feasible = sum(a.feasible for a in answers)
    how = "No point has" if not feasible else f"{feasible} of {len(answers)} points have"
    sentences = f"{how} a {by} that brings mode {mode} to {to_hz:g} Hz; beside each, where any {by} can bring it."
    return TableRows(("point", f"{by} [{UNITS[by]}]", "gives [Hz]", "in reach [Hz]"), rows, sentences)


def free_rows(answers: Sequence[FreeBand], by: By, band_hz: tuple[float, float]) -> TableRows:
    """What leaves no mode in a band at each point, the smallest first; or the mode that stays there."""
    rows = tuple((point_of(a.at), *_size_and_limit(a, by)) for a in answers)
    feasible = sum(a.feasible for a in answers)
    how = "No point has" if not feasible else f"{feasible} of {len(answers)} points have"
    edge = f"{band_hz[0]:g} to {band_hz[1]:g} Hz"
    sentences = f"{how} a {by} that leaves no mode from {edge}. There a mode is at the edge: take two sigma more."
    return TableRows(("point", f"{by} [{UNITS[by]}]", "free up to"), rows, sentences)


def _size_and_limit(a: FreeBand, by: By) -> tuple[str, str]:
    if not a.feasible:
        return "none", f"mode {a.stays} stays, at {a.stays_hz:.5g} Hz"
    limit = f"{a.up_to:.3g} {UNITS[by]}" if a.up_to < float("inf") else "any size"
    return (number_with_sigma(a.size, a.sigma) if a.size else "0: free already"), limit


def absorber_rows(found: BestAbsorber, mode: int) -> TableRows:
    """The absorber, and the largest mobility at its point without and with it."""
    a = found.absorber
    row = (
        point_of(a.at),
        f"{a.mass:.4g}",
        f"{a.frequency_hz:.5g}",
        f"{100 * a.damping_ratio:.4g}",
        number_with_sigma(found.before, found.before_sigma),
        number_with_sigma(found.after, found.after_sigma),
    )
    names = ("point", "mass [kg]", "frequency [Hz]", "damping [%]", "peak without [m/(N s)]", "peak with [m/(N s)]")
    share = f"It is {significant_digits(100 * found.mass_ratio, 2)} % of the modal mass there."
    return TableRows(names, (row,), f"The absorber of this mass that leaves the least peak about mode {mode}. {share}")
