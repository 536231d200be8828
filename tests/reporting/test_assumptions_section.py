"""The report says of each assumption whether it holds, with the number, and how well each mode stands."""

from dataclasses import replace

import numpy as np

from modallab.identification.selection.assumptions import AssumptionVerdict
from modallab.reporting.sections.verification import assumptions_section
from modallab.verification.assessment import assess_model


def test_verdicts_reasons_and_confidence_are_there(content):
    outcome = content.outcomes[0]
    verdict = AssumptionVerdict(
        "linearity", False, 0.31, 0.05, "The FRFs of the two levels differ by 31 % of their level."
    )
    confidence = np.linspace(0.5, 0.9, outcome.model.n_modes)
    found = assess_model(outcome.model, (verdict,), (("reciprocity", "one point was hit"),), confidence)
    shown = assumptions_section(replace(content, outcomes=(replace(outcome, assessment=found),)))
    body = str(shown.body)
    assert "does not hold" in body
    assert "differ by 31" in body
    assert "0.50" in body
    assert any("one point was hit" in reason for reason in shown.absent)


def test_without_an_assessment_the_section_is_left_out(content):
    bare = replace(content, outcomes=tuple(replace(o, assessment=None) for o in content.outcomes))
    assert assumptions_section(bare).body is None
