"""The same bench, written down as different labs write it."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from modallab.core.block import Block, Campaign
from modallab.core.rig import Channel, Rig
from modallab.core.units import STANDARD_GRAVITY

Convention = Callable[[Campaign], Campaign]
LBF = 4.4482216152605


def rewired(
    campaign: Campaign,
    channel: Callable[[Channel], dict[str, Any]],
    samples: Callable[[Channel], float] = lambda _: 1.0,
    **rig: object,
) -> Campaign:
    """Other fields in channels and rig, and each channel's samples times a factor."""
    believed = campaign.rig
    channels = tuple(c.model_copy(update=channel(c)) for c in believed.channels)
    factors = np.array([samples(c) for c in believed.channels])

    def block(b: Block) -> Block:
        return replace(b, samples=(b.samples * factors[:, None]).astype(b.samples.dtype))

    return replace(
        campaign,
        rig=Rig.model_validate({**believed.model_dump(), "channels": [c.model_dump() for c in channels], **rig}),
        blocks=tuple(map(block, campaign.blocks)),
    )


def scaled_sensitivity(channel: Channel, factor: float) -> dict[str, float]:
    return {test: channel.sensitivity(test) * factor for test in ("impact", "sine")}


def in_unit(quantity: str, unit: str, factor: float) -> Convention:
    """The sensitivity in volts per another unit, of `factor` SI units."""

    def channel(c: Channel) -> dict[str, Any]:
        if c.quantity != quantity:
            return {}
        return {"unit": unit, "sensitivity_v_per_unit": scaled_sensitivity(c, factor)}

    return lambda campaign: rewired(campaign, channel)


def sensors_against(names: Sequence[str] | None = None) -> Convention:
    """Some accelerometers, or all, mounted along -z and declared so."""

    def turned(c: Channel) -> bool:
        return c.quantity != "force" and (names is None or c.name in names)

    return lambda campaign: rewired(
        campaign, lambda c: {"direction": "-z"} if turned(c) else {}, lambda c: -1.0 if turned(c) else 1.0
    )


def driven_against(campaign: Campaign) -> Campaign:
    """The drive along -z: what the force pushes, the sensors along +z read as negative."""
    return rewired(
        campaign,
        lambda c: {"direction": "-z"} if c.quantity == "force" else {},
        lambda c: 1.0 if c.quantity == "force" else -1.0,
        drive_direction="-z",
    )


def both_against(campaign: Campaign) -> Campaign:
    return rewired(campaign, lambda _: {"direction": "-z"}, drive_direction="-z")


def force_turned(campaign: Campaign) -> Campaign:
    """A force transducer that reads a push along the drive as negative, declared by its direction."""
    return rewired(
        campaign,
        lambda c: {"direction": "-z"} if c.quantity == "force" else {},
        lambda c: -1.0 if c.quantity == "force" else 1.0,
    )


def negative_sensitivities(campaign: Campaign) -> Campaign:
    odd = {"force", "a03", "a08"}
    return rewired(
        campaign,
        lambda c: {"sensitivity_v_per_unit": scaled_sensitivity(c, -1.0)} if c.name in odd else {},
        lambda c: -1.0 if c.name in odd else 1.0,
    )


def permuted(order: Sequence[int]) -> Convention:
    """Rows in another order; `order[k]` is the old row of the new row k."""

    def apply(campaign: Campaign) -> Campaign:
        old = campaign.rig.channels
        channels = [{**old[i].model_dump(), "index": k} for k, i in enumerate(order)]

        def block(b: Block) -> Block:
            pick = list(order)
            return replace(
                b,
                samples=b.samples[pick],
                scale=b.scale[pick],
                units=tuple(b.units[i] for i in pick),
                channels=tuple(b.channels[i] for i in pick),
            )

        rig = Rig.model_validate({**campaign.rig.model_dump(), "channels": channels})
        return replace(campaign, rig=rig, blocks=tuple(map(block, campaign.blocks)))

    return apply


def in_millivolts(campaign: Campaign) -> Campaign:
    """Recordings whose scale gives mV."""
    return replace(
        campaign,
        blocks=tuple(replace(b, scale=b.scale * 1e3, units=("mV",) * len(b.units)) for b in campaign.blocks),
    )


def in_physical_units(force: str = "N", motion: str = "m/s^2") -> Convention:
    """Recordings of another program: real numbers in physical units, without volts."""
    size = {"N": 1.0, "lbf": LBF, "kN": 1e3, "m/s^2": 1.0, "g": STANDARD_GRAVITY, "mm/s^2": 1e-3}

    def apply(campaign: Campaign) -> Campaign:
        def block(b: Block) -> Block:
            units = tuple(force if c.quantity == "force" else motion for c in campaign.rig.channels)
            si = np.array([c.sensitivity(b.test) for c in campaign.rig.channels])
            values = b.samples * (b.scale / si)[:, None] / np.array([size[u] for u in units])[:, None]
            return replace(b, samples=values, scale=np.ones(len(units)), units=units)

        return replace(campaign, blocks=tuple(map(block, campaign.blocks)))

    return apply


def together(*conventions: Convention) -> Convention:
    def apply(campaign: Campaign) -> Campaign:
        for convention in conventions:
            campaign = convention(campaign)
        return campaign

    return apply


SAME: dict[str, Convention] = {
    "sensors -z": sensors_against(),
    "some sensors -z": sensors_against(("a02", "a05", "a10")),
    "drive -z": driven_against,
    "sensors and drive -z": both_against,
    "force -z": force_turned,
    "negative sensitivities": negative_sensitivities,
    "g": in_unit("acceleration", "g", STANDARD_GRAVITY),
    "mm/s^2": in_unit("acceleration", "mm/s^2", 1e-3),
    "lbf": in_unit("force", "lbf", LBF),
    "kN": in_unit("force", "kN", 1e3),
    "mV": in_millivolts,
    "physical units": in_physical_units(),
    "physical units lbf, g": in_physical_units("lbf", "g"),
    "physical units kN, mm/s^2": in_physical_units("kN", "mm/s^2"),
    "force in the last row": permuted((1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 0)),
    "rows permuted": permuted((7, 3, 0, 10, 1, 5, 2, 9, 4, 6, 8)),
    "all at once": together(
        in_physical_units("lbf", "g"),
        sensors_against(("a02", "a05", "a10")),
        in_unit("acceleration", "g", STANDARD_GRAVITY),
        in_unit("force", "lbf", LBF),
        permuted((7, 3, 0, 10, 1, 5, 2, 9, 4, 6, 8)),
    ),
}
"""Ways to write down the same recordings: every number that follows must be the same to rounding."""
