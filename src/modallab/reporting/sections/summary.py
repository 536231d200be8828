"""The report in one sentence."""

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
from modallab.reporting.content import ReportContent

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
