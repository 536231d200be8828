"""The twin's numbers as a document, and the twin of such a document again."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from modallab.core.diagnosis import Diagnosis, ToleranceDeviation, TwinParameters
from modallab.core.effect import Effect
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.model.fit import Fit
from modallab.gap.model.nuisances import nuisances
from modallab.gap.model.tolerances import Deviation, apply_tolerances, by_tolerance, with_tolerances
from modallab.gap.model.twin_of_fit import OF_HITS, with_own_hits
from modallab.twin.bench import MeasurementChain, Twin
from modallab.twin.effects import apply_effect, with_revision_effects
from modallab.twin.structure import MODES, TwinStructure


def calibrated_twin(fit: Fit, data: Reduced) -> TwinParameters:
    """The twin's own numbers after a fit, without its effects; those of hits as all records show them."""
    free, u = fit.problem.free, with_own_hits(fit, data)
    first = free.first_deviation
    bare = replace(free, deviations=())
    twin = bare.bare(np.delete(u[: free.size], np.arange(first, first + len(free.deviations))))
    replaced = fit.problem.replaced
    kept = [
        ToleranceDeviation(tolerance=d.tolerance, at=d.at, sigma=d.sigma, sign=d.sign, u=float(v))
        for d, v in zip(free.deviations, u[first : first + len(free.deviations)], strict=True)
        if not {(d.tolerance, None), (d.tolerance, d.at)} & replaced
    ]
    s = twin.structure
    return TwinParameters(
        youngs_modulus_pa=s.youngs_modulus_pa,
        thickness_m=s.thickness_m,
        density_kg_m3=s.density_kg_m3,
        zeta=s.zeta.tolist(),
        gains=dict(twin.chain.gain),
        residual_compliance=twin.residual_compliance,
        root_rotation=s.root_rotation,
        departures=kept,
        drift_curve=list(fit.problem.drift_curve),
    )


def diagnosed_twin(diagnosis: Diagnosis, rig: Rig, of_others: bool = True) -> Twin:
    """The twin of a diagnosis, effects included.

    Args:
        diagnosis: of a campaign on this rig.
        rig: the bench as believed.
        of_others: whether it is for another campaign, whose hits land elsewhere, and not for the diagnosed one.

    Raises:
        DataError: the rig has no beam, or the diagnosis is not of as many modes as the twin has.
    """
    described = diagnosis.described
    numbers = diagnosis.twin if described is None else described.twin
    if rig.beam is None or len(numbers.zeta) != MODES:
        raise DataError(
            f"the diagnosis holds {len(numbers.zeta)} damping ratios, the twin {MODES} modes",
            where=rig.name,
            remedy="diagnose again with this version",
        )
    structure = replace(
        TwinStructure.of(rig.beam, rig.damping_ratio.guess),
        youngs_modulus_pa=numbers.youngs_modulus_pa,
        thickness_m=numbers.thickness_m,
        density_kg_m3=numbers.density_kg_m3,
        zeta=np.array(numbers.zeta),
        root_rotation=numbers.root_rotation,
    )
    twin = Twin(structure, MeasurementChain.of(rig), residual_compliance=numbers.residual_compliance)
    if numbers.departures:
        twin = apply_tolerances(
            twin, rig, by_tolerance(_listed_departures(numbers.departures, OF_HITS if of_others else ()))
        )
    twin = replace(twin, chain=replace(twin.chain, gain=dict(numbers.gains)))
    twin = with_revision_effects(twin, rig)
    for effect in effects_for_twin(diagnosis):
        twin = apply_effect(twin, effect, rig)
    return twin if of_others else replace(twin, drift_curve=tuple(numbers.drift_curve))


def effects_for_twin(diagnosis: Diagnosis) -> list[Effect]:
    """What a diagnosis adds to the twin: the effects found, or the elements that a gap without a name behaves like."""
    learned = [] if diagnosis.described is None else diagnosis.described.elements
    return [*(found.as_effect() for found in diagnosis.effects), *(element.as_effect() for element in learned)]


def twin_of_rig_file(rig: Rig) -> Twin:
    """The twin as a rig file has it, nothing fitted.

    Raises:
        RigError: the rig has no beam.
    """
    free = nuisances(with_tolerances(rig), 0.0)
    return free.build(np.zeros(free.size))


def _listed_departures(
    listed: Collection[ToleranceDeviation], left_out: Collection[str]
) -> list[tuple[Deviation, float]]:
    own = [(Deviation(d.tolerance, d.at, d.sigma, d.sign), d.u) for d in listed if d.tolerance not in left_out]
    return [(deviation, deviation.value(u)) for deviation, u in own]
