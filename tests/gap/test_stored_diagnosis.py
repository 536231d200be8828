"""A diagnosis that an earlier version wrote is read."""

from modallab.core.diagnosis import CandidateSet, Diagnosis, Gap, GapLocation, Shrinkage, TwinParameters


def test_a_diagnosis_of_version_1_is_read() -> None:
    gap = Gap(
        before=2.0, floor=1.0, after=1.0, by_record={}, by_test={}, by_level={}, by_channel={}, after_by_channel={},
        by_band={}, by_mode={}, by_order={}, poles_hz=[4.7],
    )  # fmt: skip
    new = Diagnosis(
        rig="link",
        verdict="no_gap",
        gap=gap,
        where=GapLocation(stage=None, channels=[], x_m=None, tests=[], bands=[], share=0.0, why=[]),
        effects=[],
        candidates=[CandidateSet(effects=["polarity"], probability=0.1, gap=2.0)],
        shrink=Shrinkage(held_out=[], before=2.0, after=1.0, closed=None, interval=None, rival={}),
        next_experiment="",
        twin=TwinParameters(
            youngs_modulus_pa=2e11, thickness_m=5e-3, density_kg_m3=7850, zeta=[0.01], residual_compliance=0.3
        ),
        notes=[],
    )
    text = new.model_dump_json()
    old = text.replace('"residual_compliance"', '"rest"').replace('"format_version":2', '"format_version":1')
    assert old != text
    assert Diagnosis.model_validate_json(old).twin == new.twin
