"""How far records that a simulation predicts lie from the bench's, in the same noise units as any gap."""

from collections.abc import Collection
from dataclasses import replace

from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.gap.conditioning.prepare import prepare_campaign
from modallab.gap.conditioning.reduce import reduce_blocks
from modallab.gap.design.prediction import Records, with_records
from modallab.gap.model.fit import all_rows
from modallab.gap.model.tolerances import with_tolerances
from modallab.gap.report.initial_gap import weights_of
from modallab.gap.report.measure import SquaredResiduals, squares_of


def simulation_residual(campaign: Campaign, records: Records, names: Collection[str] | None = None) -> SquaredResiduals:
    """Squares of measured less predicted in noise units; nothing is fitted.

    Args:
        campaign: the bench's records.
        records: record -> (channels, n) in each response channel's own unit and direction.
        names: records that count; None for all that were predicted.

    Raises:
        DataError: no record of the campaign was predicted.
    """
    prepared = prepare_campaign(replace(campaign, rig=with_tolerances(campaign.rig)))
    blocks = [b for b in prepared.blocks if b.name in records and (names is None or b.name in names)]
    if not blocks:
        raise DataError(
            f"none of the {len(records)} predicted records is one of the {len(prepared.blocks)} of the campaign",
            where=campaign.source,
            remedy="name the records as the campaign does",
        )
    weights = weights_of(prepared)
    measured = reduce_blocks(prepared.campaign, blocks, weights)
    simulated = with_records(replace(prepared.campaign, blocks=tuple(blocks)), records)
    same = reduce_blocks(replace(simulated, blocks=prepared.campaign.blocks), simulated.blocks, weights)
    return squares_of([rows.y for rows in all_rows(same)], measured)
