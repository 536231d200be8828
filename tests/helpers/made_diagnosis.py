"""A diagnosis as a document, without a search."""

from modallab.core.diagnosis import Diagnosis, FoundEffect, Gap, GapLocation, Shrinkage, TwinParameters, Verdict
from modallab.core.effect import AlongBeam
from modallab.core.effects import Effect, kind_of
from modallab.core.rig import Rig
from modallab.twin.structure import MODES


def made_diagnosis(rig: Rig, *effects: Effect, verdict: Verdict = "known", probability: float = 0.9) -> Diagnosis:
    """What a search would say that has found these effects on an otherwise right bench of `twin_campaign`."""
    assert rig.beam is not None
    gap = Gap(
        before=300.0, floor=1.0, after=1.0, by_record={}, by_test={"impact": 300.0}, by_level={}, by_channel={},
        after_by_channel={}, by_band={}, by_mode={}, by_order={}, poles_hz=[],
    )  # fmt: skip
    found = [
        FoundEffect(
            effect=e.effect,
            stage=kind_of(e.effect).stage,
            probability=probability,
            parameters=e.parameters,
            interval={name: (0.9 * value, 1.1 * value) for name, value in e.parameters.items()},
            place=e.place,
        )
        for e in effects
    ]
    x = next((e.place.x * rig.beam.length_m for e in effects if isinstance(e.place, AlongBeam)), None)
    stage = found[0].stage if found else None
    return Diagnosis(
        rig=rig.name,
        verdict=verdict,
        gap=gap,
        where=GapLocation(stage=stage, channels=[], x_m=x, tests=["impact"], bands=[], share=1.0, why=[]),
        effects=found,
        candidates=[],
        shrink=Shrinkage(
            held_out=["impact_p10_0", "impact_p10_1"],
            before=300.0,
            after=1.1,
            closed=0.999,
            interval=(0.99, 1.0),
            rival={},
        ),
        next_experiment="",
        twin=TwinParameters(
            youngs_modulus_pa=2.06e11,
            thickness_m=rig.beam.thickness_m,
            density_kg_m3=7840.0,
            zeta=[0.006 * (0.7 + 0.8 * k / (MODES - 1)) for k in range(MODES)],
        ),
        notes=[],
    )
