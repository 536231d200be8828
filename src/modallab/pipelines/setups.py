"""Identifies every set-up of a test, compares them, and joins them into one model."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.frf.estimate import group_by_point, impact_frf
from modallab.identification.frf_model import frf_in_band
from modallab.identification.options import IdentificationOptions
from modallab.identification.setups.compare import ComparedSetUp, compare_setups
from modallab.identification.setups.found import SetUpModel, joined_name, same_modes
from modallab.identification.setups.join import join_setups, require_same_points
from modallab.identification.setups.readings import SetUpReading, readings_of_setups
from modallab.pipelines.identify import CampaignResult, IdentifiedTest, identify_campaign, usable_blocks


@dataclass(frozen=True, eq=False, slots=True)
class JoinedSetups:
    """Several set-ups of one hammer test, or several sets of FRFs, as one.

    Attributes:
        result: the joined model.
        compared: each set-up against the one that the others are compared with.
        setups: the models of the set-ups.
        campaign: the joined outputs as a rig, without records, which are those of the set-ups.
        readings: what each set-up read of the joined modes.
    """

    result: CampaignResult
    compared: tuple[ComparedSetUp, ...]
    setups: tuple[SetUpModel, ...]
    campaign: Campaign
    readings: tuple[SetUpReading, ...]


def identify_setups(campaigns: Sequence[Campaign], options: IdentificationOptions) -> JoinedSetups:
    """One modal model of the hits of several set-ups, or of the FRFs where that is all they hold.

    Args:
        campaigns: one a set-up, each with the rig as it stood then.
        options: as for one campaign.

    Raises:
        DataError: fewer than two set-ups, one of them twice, struck at different points, FRFs beside records, or FRFs
            at other lines.
        IdentificationError: a set-up has no mode, or no mode is in all of them.
    """
    if options.frf != "H1":
        raise DataError(
            f"set-ups are joined by their records, which have no {options.frf}",
            remedy="leave the kind of FRF out, or identify each set-up by itself",
        )
    if len(campaigns) < 2:
        raise DataError(f"{len(campaigns)} set-up cannot be joined: give two or more", remedy="name at least two")
    names = setup_names(campaigns)
    require_distinct(campaigns)
    require_same_points([(n, _struck_points(c)) for n, c in zip(names, campaigns, strict=True)])
    found = tuple(_identify_setup(campaign, name, options) for campaign, name in zip(campaigns, names, strict=True))
    modes = same_modes(found)
    compared = compare_setups(found, modes)
    model = join_setups(found, modes, compared)
    frf, first = _measured_frfs(campaigns, model), campaigns[0]
    joined = Campaign(_joined_rig(campaigns), (), (frf,), common_provenance(campaigns), first.source)
    # The records stay with their set-ups: the joined campaign holds FRFs.
    return JoinedSetups(
        CampaignResult((IdentifiedTest("frf", model, None),), ()),
        compared,
        found,
        joined,
        readings_of_setups(found, modes, compared),
    )


def require_distinct(campaigns: Sequence[Campaign]) -> None:
    """Reject records that count twice: the joined sigmas would be too small."""
    seen: dict[bytes, Campaign] = {}
    for campaign in campaigns:
        for held in (*(b.samples for b in campaign.blocks[:1]), *(f.values for f in campaign.frfs[:1])):
            twin = seen.setdefault(held.tobytes(), campaign)
            if twin is not campaign:
                raise DataError(
                    f"contains the same records as {twin.source}",
                    where=campaign.source,
                    remedy="name every set-up once",
                )


def _struck_points(campaign: Campaign) -> tuple[int | None, ...]:
    if _is_frfs_alone(campaign):
        return campaign.frfs[0].input_points
    return tuple(dict.fromkeys(block.drive_point for block in campaign.of("impact")))


def _is_frfs_alone(campaign: Campaign) -> bool:
    """Whether a campaign is one set of FRFs and nothing else."""
    return len(campaign.frfs) == 1 and not campaign.blocks


def setup_names(campaigns: Sequence[Campaign]) -> tuple[str, ...]:
    """What each set-up is called: by its plan, else by its file, else by its number."""
    names = [c.provenance.get("setup") or Path(c.source).stem for c in campaigns]
    return tuple(name if name and names.count(name) == 1 else f"{n + 1}" for n, name in enumerate(names))


def _identify_setup(campaign: Campaign, name: str, options: IdentificationOptions) -> SetUpModel:
    (item,) = identify_campaign(campaign, options, None if _is_frfs_alone(campaign) else "impact").identified
    return SetUpModel(name, item.model, tuple(c.mass_kg for c in campaign.rig.of_outputs(item.model.outputs).responses))


def common_provenance(campaigns: Sequence[Campaign]) -> dict[str, str]:
    """What all sources say alike: a simulated bench has other modes with its sensors elsewhere."""
    known = campaigns[0].provenance
    return {key: value for key, value in known.items() if all(c.provenance.get(key) == value for c in campaigns)}


def _measured_frfs(campaigns: Sequence[Campaign], model: ModalModel) -> Frf:
    """The FRFs of all set-ups, in the order of the joined outputs; of a sensor that stays those of the first."""
    rows: dict[str, NDArray[np.complex128]] = {}
    frfs = [_frf_of_campaign(campaign, model.band_hz) for campaign in campaigns]
    _require_same_lines(campaigns, frfs)
    for campaign, frf in zip(campaigns, frfs, strict=True):
        for channel, values in zip(campaign.rig.of_outputs(frf.outputs).responses, frf.values, strict=True):
            rows.setdefault(joined_name(channel.name, channel.point), values)
    return Frf(
        frequency_hz=frfs[0].frequency_hz,
        values=np.stack([rows[name] for name in model.outputs]),
        quantity=frfs[0].quantity,
        outputs=model.outputs,
        output_points=model.output_points,
        input_points=model.input_points,
    )


def _require_same_lines(campaigns: Sequence[Campaign], frfs: Sequence[Frf]) -> None:
    first = frfs[0].frequency_hz
    for campaign, frf in zip(campaigns, frfs, strict=True):
        if len(frf.frequency_hz) != len(first) or not np.allclose(frf.frequency_hz, first, rtol=1e-6):
            raise DataError(
                f"its {len(frf.frequency_hz)} lines in the band are not the {len(first)} of {campaigns[0].source}",
                where=campaign.source,
                remedy="give all set-ups at the same lines",
            )


def _frf_of_campaign(campaign: Campaign, band_hz: tuple[float, float]) -> Frf:
    if _is_frfs_alone(campaign):
        return frf_in_band(campaign.frfs[0], band_hz)
    signals, rig, _ = usable_blocks(campaign, campaign.of("impact"))
    return impact_frf(group_by_point(signals), rig, band_hz)


def _joined_rig(campaigns: Sequence[Campaign]) -> Rig:
    """The first rig with a channel for every sensor at every point where it stood."""
    rig = campaigns[0].rig
    seen = {joined_name(c.name, c.point): c for campaign in campaigns for c in campaign.rig.responses}
    ordered = sorted(seen.items(), key=lambda pair: (pair[1].point is None, pair[1].point or 0))
    renamed = [c.model_copy(update={"name": name, "input": ""}) for name, c in ordered]
    channels = [c.model_copy(update={"index": n}) for n, c in enumerate([rig.force_channel, *renamed])]
    return Rig.model_validate(rig.model_copy(update={"channels": tuple(channels), "shakers": ()}).model_dump())
