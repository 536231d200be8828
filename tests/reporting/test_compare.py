from math import isnan, nan

import figure_data
import numpy as np
import pytest

from modallab.identification.selection.criteria import nearest_partners
from modallab.reporting.compare import agreement_verdict, joint_deviations, matched_modes
from modallab.reporting.content import TrueModes


def test_modes_of_two_tests_are_matched_and_sorted():
    impact = figure_data.model()
    sine = figure_data.model("sine", 4, 4)
    found = matched_modes([impact, sine], TrueModes(figure_data.FREQUENCY, figure_data.DAMPING))
    assert [m.number for m in found] == [1, 2, 3]
    assert all([r.test for r in m.readings] == ["impact", "sine"] for m in found)
    assert [m.true_frequency_hz for m in found] == list(figure_data.FREQUENCY)
    assert [m.readings[1].damping for m in found] == list(sine.damping_ratio)


def test_a_mode_that_only_the_second_test_saw_is_there_too():
    first = figure_data.model()
    kept = {
        name: getattr(first, name)[[0, 2]]
        for name in (
            "frequency_hz",
            "damping_ratio",
            "frequency_sigma_hz",
            "damping_sigma",
            "modal_constants",
            "modal_constant_sigma",
            "shapes",
            "shape_sigma",
            "half_power",
            "half_power_floor",
        )
    }
    found = matched_modes([figure_data.model(**kept), figure_data.model("sine", 4, 4)])
    assert [len(m.readings) for m in found] == [2, 1, 2]
    assert found[1].readings[0].test == "sine"
    assert isnan(found[0].true_frequency_hz)


def test_partners_are_nearest_to_one_another_and_near():
    assert nearest_partners([10.0, 10.2, 50.0], [10.1, 60.0]) == [0, None, None]
    assert nearest_partners([], [1.0]) == []
    assert nearest_partners([1.0], []) == [None]


def test_no_models_no_modes():
    assert matched_modes([]) == ()


@pytest.mark.parametrize(("d", "word"), [(0.0, "agree"), (2.0, "agree"), (2.5, "borderline"), (9.0, "disagree")])
def test_the_verdict_follows_the_joint_sigmas(d, word):
    assert agreement_verdict(d) == word


def test_the_deviation_is_in_joint_sigmas():
    assert joint_deviations(10.0, 3.0, 20.0, 4.0) == pytest.approx(2.0)
    assert isnan(joint_deviations(10.0, nan, 20.0, 1.0))
    assert agreement_verdict(nan) == "unknown"


def test_good_pairs_agree_nineteen_times_in_twenty():
    rng = np.random.default_rng(1)
    a, b = rng.standard_normal((2, 4000)) * [[0.5], [2.0]]
    words = [agreement_verdict(joint_deviations(x, 0.5, y, 2.0)) for x, y in zip(a, b, strict=True)]
    assert words.count("agree") / len(words) == pytest.approx(0.954, abs=0.01)
    assert words.count("disagree") / len(words) < 0.006
