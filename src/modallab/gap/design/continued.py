"""A campaign that goes on: records of a later session behind those of the first."""

from dataclasses import replace

from modallab.core.block import Campaign


def continue_campaign(campaign: Campaign, later: Campaign) -> Campaign:
    """A campaign with the records of a later one behind its own, under names that are free."""
    first = 1 + max((b.order for b in campaign.blocks), default=-1)
    taken = {b.name for b in campaign.blocks}
    added = tuple(
        replace(b, order=first + k, name=_free_name(b.name, taken))
        for k, b in enumerate(sorted(later.blocks, key=lambda b: b.order))
    )
    return replace(campaign, blocks=(*campaign.blocks, *added))


def _free_name(name: str, taken: set[str]) -> str:
    number = 2
    free = name
    while free in taken:
        free, number = f"{name}_{number}", number + 1
    taken.add(free)
    return free
