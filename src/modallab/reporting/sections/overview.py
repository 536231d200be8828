"""What a reader wants to know in ten seconds: is it good, and if not, where to look."""

from collections.abc import Iterator
from math import isfinite

import numpy as np

from modallab.core.digits import four_places, in_sigmas, list_in_words, significant_digits, with_nonbreaking_spaces
from modallab.reporting.compare import ComparedMode, agreement_verdict
from modallab.reporting.content import OutcomeOfTest, ReportContent
from modallab.reporting.markup import Markup, html_element
from modallab.reporting.sections.summary import MATCH, compare_tests, largest_differences

DOUBTFUL = 0.5
"""A mode of a lower confidence may be noise, or what the model leaves unexplained."""


def overview_list(content: ReportContent, modes: tuple[ComparedMode, ...]) -> Markup | None:
    """A short list, each line marked as good or as to be looked at; None without a model."""
    if not content.models:
        return None
    lines = [
        *_modes_known(modes),
        *(line for outcome in content.outcomes for line in _repeated_line(outcome)),
        *_tests_agree(modes),
        *(line for outcome in content.outcomes for line in _assumptions_line(outcome)),
    ]
    return html_element(
        "ul", *(_list_line(good, text) for good, text in lines), class_="glance", aria_label="At a glance"
    )


def _list_line(good: bool, text: str) -> Markup:
    mark = html_element("i", "\N{HEAVY CHECK MARK}" if good else "!", aria_label="good:" if good else "to check:")
    return html_element(
        "li", mark, html_element("span", with_nonbreaking_spaces(text)), class_="good" if good else "look"
    )


def _modes_known(modes: tuple[ComparedMode, ...]) -> Iterator[tuple[bool, str]]:
    readings = [mode.best for mode in modes]
    f = [100 * r.frequency_sigma_hz / r.frequency_hz for r in readings]
    zeta = [100 * r.damping_sigma / r.damping for r in readings if r.damping > 0]
    if f and zeta and all(map(isfinite, (*f, *zeta))):
        claim = (
            f"known to {significant_digits(max(f), 2)} % or better, damping ratios to "
            f"{significant_digits(max(zeta), 2)} %"
        )
        yield True, f"Natural frequencies are {claim} (one standard deviation)."
    doubted = [significant_digits(m.frequency_hz) for m in modes if _best_confidence(m) < DOUBTFUL]
    if doubted:
        yield False, f"Doubtful: {list_in_words(doubted)} Hz, of a confidence below {DOUBTFUL:g}."


def _best_confidence(mode: ComparedMode) -> float:
    found = [r.confidence for r in mode.readings if isfinite(r.confidence)]
    return max(found, default=1.0)


def _repeated_line(outcome: OutcomeOfTest) -> Iterator[tuple[bool, str]]:
    if outcome.verification is None:
        return
    found = np.nan_to_num(outcome.verification.frac, nan=0.0)
    good = bool(found.min() >= MATCH)
    claim = "The model repeats" if good else "At some points the model does not reproduce"
    frac = f"FRAC is {'at least' if good else 'down to'} {four_places(found.min())}"
    yield good, f"{claim} the measurement of {_name_of_test(outcome)}: {frac}."


def _tests_agree(modes: tuple[ComparedMode, ...]) -> Iterator[tuple[bool, str]]:
    pairs = compare_tests(modes)
    apart = [d for _, *both in pairs for d in both if isfinite(d)]
    if apart:
        one, other = (r.test for r in pairs[0][0].readings[:2])
        most = in_sigmas(max(apart))
        if agreement_verdict(max(apart)) == "agree":
            yield True, f"The {one} and the {other} test agree: they differ by at most {most}."
            return
        text = f"The {one} and the {other} test differ by up to {most}: {largest_differences(modes)}."
        driven = {one, other} - {"impact", None}
        if "impact" in (one, other) and driven:
            text += f" In the {driven.pop()} test the shaker is attached to the structure, which shifts its modes."
        yield False, text


def _assumptions_line(outcome: OutcomeOfTest) -> Iterator[tuple[bool, str]]:
    if outcome.assessment is None or not outcome.assessment.verdicts:
        return
    for holds in (True, False):
        names = [v.assumption for v in outcome.assessment.verdicts if v.holds == holds]
        if names:
            many = len(names) > 1
            claim = ("hold" if many else "holds") if holds else ("do not hold" if many else "does not hold")
            text = f"{list_in_words(names)} {claim} in {_name_of_test(outcome)}."
            yield holds, text[0].upper() + text[1:]


def _name_of_test(outcome: OutcomeOfTest) -> str:
    return f"the {outcome.test} test" if outcome.test else "the FRFs"
