"""A diagnosis at work: what the accelerometers of another campaign on the same rig would read."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.gap.conditioning.prepare import as_volts, usable
from modallab.gap.conditioning.reduce import Weights, sine_ratio
from modallab.gap.model.predicted_records import predict_record
from modallab.signals.alignment import lags_s
from modallab.signals.conversion import unit_per_si, volts_per_si
from modallab.signals.signals import to_signals
from modallab.twin.bench import Chain, Twin
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
    twin = Twin(structure, Chain.of(rig), residual_compliance=numbers.residual_compliance)
    twin = replace(twin, chain=replace(twin.chain, gain=dict(numbers.gains)))
    for found in diagnosis.effects:
        twin = apply(twin, found.as_effect(), rig)
    return twin


def predict(diagnosis: Diagnosis, other: Campaign) -> dict[str, Array]:
    """Record -> (channels, n): what each response channel of another campaign would read, each record begun from rest.

    Every row is in its channel's own unit, in the direction of its positive readings, and as late and as AC-coupled as
    the rig file says the channel is.

    Args:
        diagnosis: of a campaign on the same rig.
        other: the campaign to predict; only its forces are read.

    Raises:
        DataError: the rig has no beam, the diagnosis is another version's, or no record says what drove it.
    """
    rig, other = other.rig, as_volts(other)
    twin = diagnosed_twin(diagnosis, rig)
    twin = replace(twin, chain=twin.chain.as_delivered(rig, lags_s(rig)))
    blocks = usable(other)
    ratio = _clock(other, blocks)
    last = float(max(1, *(b.order for b in other.blocks)))
    rows = [c.index for c in rig.responses]
    cut = {int(f.place["channel"]): float(f.place["level_v"]) for f in diagnosis.effects if "level_v" in f.place}
    found: dict[str, Array] = {}
    for b in blocks:
        si = predict_record(twin, rig, b, last, ratio)
        limit = np.array([cut.get(row, np.inf) for row in rows]) / np.abs(volts_per_si(rig, b.test)[rows])
        found[b.name] = np.clip(si, -limit[:, None], limit[:, None]) * unit_per_si(rig)[rows, None]
    return found


def _clock(campaign: Campaign, blocks: Sequence[Block]) -> float:
    rig = campaign.rig
    sines = [to_signals(b, rig) for b in blocks if b.test == "sine"]
    if not sines:
        return 1.0
    noise = np.full(len(rig.channels), rig.converter.noise_rms_v if rig.converter is not None else 3e-4)
    seen, spread = sine_ratio(sines, Weights(noise).force(rig, "sine"))
    return seen if abs(seen - 1) > 5 * spread else 1.0
