"""The assumptions of an impact test: held by a linear bench, broken by one that is not."""

import json
from dataclasses import replace

import modal_bench as bench
import numpy as np

from modallab.core.block import Campaign
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.model_file import write_models


def campaign(seed=4, change=lambda block, k: block):
    rng = np.random.default_rng(seed)
    blocks = bench.impact_blocks(bench.modes(rng), rng, points=(3, 5), hits=2)
    return Campaign(rig=bench.rig(5), blocks=tuple(change(b, k) for k, b in enumerate(blocks)))


def verdicts(found):
    return {v.assumption: v for v in found.identified[0].assessment.verdicts}


def test_a_linear_bench_passes_every_verdict(tmp_path):
    it = campaign()
    found = identify_campaign(it, IdentificationOptions())
    assert all(v.holds for v in verdicts(found).values())
    assert {"time invariance", "reciprocity", "driving point", "proportional damping"} <= set(verdicts(found))
    assessment = found.identified[0].assessment
    assert np.all(assessment.confidence > 0.5)
    assert np.all(assessment.mpc > 0.99)
    write_models(tmp_path / "m.json", it, found)
    written = json.loads((tmp_path / "m.json").read_text())
    assert written["assessments"][0]["confidence"] == assessment.confidence.tolist()
    assert len(written["assessments"][0]["verdicts"]) == len(assessment.verdicts)


def test_a_sensor_that_loses_sensitivity_is_no_constant_structure():
    def tired(block, k):
        samples = block.samples.astype(float)
        samples[2] *= 0.8 if k % 2 else 1.0
        return replace(block, samples=samples)

    verdict = verdicts(identify_campaign(campaign(change=tired), IdentificationOptions()))["time invariance"]
    assert not verdict.holds
    assert 0.1 < verdict.value < 0.3


def test_a_sensor_with_the_wrong_sensitivity_breaks_reciprocity():
    def wrong(block, k):
        samples = block.samples.astype(float)
        samples[3] *= 1.3
        return replace(block, samples=samples)

    verdict = verdicts(identify_campaign(campaign(change=wrong), IdentificationOptions()))["reciprocity"]
    assert not verdict.holds
    assert 0.2 < verdict.value < 0.32
