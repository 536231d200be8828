"""A diagnosis at work: what the accelerometers of another campaign on the same rig would read."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.gap.conditioning.prepare import usable
from modallab.gap.conditioning.reduce import Weights, sine_ratio
from modallab.gap.model.predicted_records import predict_record
from modallab.twin.bench import Twin
from modallab.twin.effects import apply
from modallab.twin.structure import MODES, Structure

Array = NDArray[np.float64]


def diagnosed_twin(diagnosis: Diagnosis, rig: Rig) -> Twin:
    """The twin of a diagnosis, effects included.

    Raises:
        DataError: the rig has no beam, or the diagnosis is not of as many modes as the twin has.
    """
    numbers = diagnosis.twin
    if rig.beam is None or len(numbers.zeta) != MODES:
        raise DataError(
            f"the diagnosis holds {len(numbers.zeta)} damping ratios, the twin {MODES} modes",
            where=rig.name,
            remedy="diagnose again with this version",
        )
    structure = replace(
        Structure.of(rig.beam, rig.damping_ratio.guess),
        youngs_modulus_pa=numbers.youngs_modulus_pa,
        thickness_m=numbers.thickness_m,
        density_kg_m3=numbers.density_kg_m3,
        zeta=np.array(numbers.zeta),
        root_rotation=numbers.root_rotation,
    )
    twin = Twin(structure, residual_compliance=numbers.residual_compliance)
    twin = replace(twin, chain=replace(twin.chain, gain=dict(numbers.gains)))
    for found in diagnosis.effects:
        twin = apply(twin, found.as_effect(), rig)
    return twin


def predict(diagnosis: Diagnosis, other: Campaign) -> dict[str, Array]:
    """Record -> (channels, n) in m/s^2 at nominal sensitivities, each begun from rest."""
    rig = other.rig
    twin = diagnosed_twin(diagnosis, rig)
    blocks = usable(other)
    sines = [b for b in blocks if b.test == "sine"]
    ratio = 1.0
    if sines:
        noise = np.full(len(rig.channels), rig.converter.noise_rms_v if rig.converter is not None else 3e-4)
        seen, spread = sine_ratio(sines, rig, Weights(noise).force(rig, "sine"))
        ratio = seen if abs(seen - 1) > 5 * spread else 1.0
    last = float(max(1, *(b.order for b in other.blocks)))
    cut = {int(f.place["channel"]): float(f.place["level_v"]) for f in diagnosis.effects if "level_v" in f.place}
    return {b.name: _cut(predict_record(twin, rig, b, last, ratio), rig, b.test, cut) for b in blocks}


def _cut(y: Array, rig: Rig, test: str, cut: dict[int, float]) -> Array:
    for i, channel in enumerate(rig.responses):
        if channel.index in cut:
            level = cut[channel.index] / abs(channel.sensitivity("sine" if test == "sine" else "impact"))
            y[i] = np.clip(y[i], -level, level)
    return y
