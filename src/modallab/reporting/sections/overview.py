"""What a reader wants to know in ten seconds: is it good, and if not, where to look."""

from collections.abc import Iterator
from math import isfinite

import numpy as np

from modallab.core.digits import (
    count_with_noun,
    four_places,
    in_sigmas,
    list_in_words,
    significant_digits,
    three_digits,
    with_nonbreaking_spaces,
)
from modallab.reporting.compare import ComparedMode, agreement_verdict, joint_deviations
from modallab.reporting.content import OutcomeOfTest, ReportContent
from modallab.reporting.markup import Markup, html_element

MATCH = 0.9
"""A point with a lower FRAC is not matched by the model."""


def summary_sentence(content: ReportContent, modes: tuple[ComparedMode, ...]) -> str:
    """What was found, in one sentence."""
    return with_nonbreaking_spaces(_sentence_of_modes(content, modes))


def _sentence_of_modes(content: ReportContent, modes: tuple[ComparedMode, ...]) -> str:
    if not content.models:
        return "No modal model could be identified; the reasons follow below."
    if not modes:
        low, high = content.models[0].band_hz
        return f"No mode was found between {three_digits(low)} and {three_digits(high)} Hz."
    low, high = (f(m.band_hz[i] for m in content.models) for i, f in enumerate((min, max)))
    head = f"{count_with_noun(len(modes), 'mode')} between {three_digits(low)} and {three_digits(high)} Hz"
    return (
        f"{head}{_unscaled_note(content)}: "
        f"{_modes_in_words(modes)}{_agreement_sentence(modes)}{_mismatch_note(content)}."
    )


def _unscaled_note(content: ReportContent) -> str:
    alone = all(model.operating_shapes is not None for model in content.models)
    return " from the responses alone, with unscaled shapes" if alone else ""


def compare_tests(modes: tuple[ComparedMode, ...]) -> list[tuple[ComparedMode, float, float]]:
    """Each mode that two tests saw, with the joint sigmas between them in frequency and in damping."""
    pairs = [(m, *m.readings[:2]) for m in modes if len(m.readings) > 1]
    return [
        (
            m,
            joint_deviations(a.frequency_hz, a.frequency_sigma_hz, b.frequency_hz, b.frequency_sigma_hz),
            joint_deviations(a.damping, a.damping_sigma, b.damping, b.damping_sigma),
        )
        for m, a, b in pairs
    ]


def _mismatch_note(content: ReportContent) -> str:
    """Where the model does not reproduce what was measured."""
    checks = [(o, float(np.nan_to_num(o.verification.frac, nan=0.0).min())) for o in content.outcomes if o.verification]
    bad = [
        f"{f'the {o.test} test' if o.test else 'the FRFs'} (FRAC down to {four_places(f)})"
        for o, f in checks
        if f < MATCH
    ]
    return f"; at some points the model does not reproduce {list_in_words(bad)}" if bad else ""


def _modes_in_words(modes: tuple[ComparedMode, ...]) -> str:
    if len(modes) > 4:
        frequencies = list_in_words([significant_digits(m.frequency_hz) for m in modes])
        low, high = (100 * f(m.best.damping for m in modes) for f in (min, max))
        return (
            f"{frequencies} Hz, with damping ratios from {significant_digits(low, 2)} to "
            f"{significant_digits(high, 2)} %"
        )
    return list_in_words(
        [
            f"{significant_digits(m.frequency_hz)} Hz with a damping ratio of "
            f"{significant_digits(100 * m.best.damping, 2)} %"
            for m in modes
        ]
    )


def _agreement_sentence(modes: tuple[ComparedMode, ...]) -> str:
    pairs = compare_tests(modes)
    gaps = [d for _, *both in pairs for d in both if isfinite(d)]
    if not gaps:
        return ""
    tests = " and ".join(f"the {r.test} test" for r in pairs[0][0].readings[:2])
    found = agreement_verdict(max(gaps))
    if found == "agree":
        return f"; {tests} agree within their uncertainty"
    if found == "borderline":
        return f"; {tests} agree but for one value that lies {in_sigmas(max(gaps))} apart"
    return f"; {tests} disagree, {largest_differences(modes)}"


def largest_differences(modes: tuple[ComparedMode, ...]) -> str:
    """How far two tests are apart at most, as people compare them first: in percent."""
    pairs = [m.readings[:2] for m in modes if len(m.readings) > 1]
    hz, zeta = (
        max((abs(b / a - 1) for a, b in values if a > 0 and isfinite(b / a)), default=0.0)
        for values in (
            [(a.frequency_hz, b.frequency_hz) for a, b in pairs],
            [(a.damping, b.damping) for a, b in pairs],
        )
    )
    return (
        f"frequencies by up to {significant_digits(100 * hz, 2)} %, damping ratios by up to "
        f"{significant_digits(100 * zeta, 2)} % of their value"
    )


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
