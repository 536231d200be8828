"""Identifies several set-ups of responses alone, and joins them by the sensors that stay."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.errors import DataError, IdentificationError
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Rig
from modallab.core.units import Test
from modallab.identification.options import Options
from modallab.identification.setups.found import joined_name
from modallab.identification.setups.join_responses import Freedom, JoinedResponses, ResponseSetUp, join_responses
from modallab.identification.setups.readings import SetUpReading
from modallab.pipelines.identify import Identified, Result
from modallab.pipelines.response_only import USUAL_RESPONSE, ResponseMethod, identify_responses
from modallab.pipelines.setups import common_provenance, require_distinct, setup_names

FAR = 4.0
"""Sigmas by which a set-up's frequency is off the joined one."""


@dataclass(frozen=True, eq=False, slots=True)
class JoinedAlone:
    """Several set-ups of responses alone as one.

    Attributes:
        result: the joined model.
        campaign: the joined outputs as a rig, without records, which are those of the set-ups.
        models: of the set-ups.
        readings: what each set-up read of the joined modes.
    """

    result: Result
    campaign: Campaign
    models: tuple[ModalModel, ...]
    readings: tuple[SetUpReading, ...]


def identify_response_setups(
    campaigns: Sequence[Campaign],
    options: Options,
    test: Test | None = None,
    method: ResponseMethod = USUAL_RESPONSE,
) -> JoinedAlone:
    """One model of the responses of several set-ups.

    Args:
        campaigns: one a set-up, each with the rig as its sensors stood then.
        options: of which only the band goes with the responses alone.
        test: only this test's records.
        method: how modes are found.

    Raises:
        DataError: fewer than two set-ups, one of them twice, a sensor without a point, or nothing that joins them.
        IdentificationError: a set-up has no mode, no mode is in all of them, or options that have no place here.
    """
    if len(campaigns) < 2:
        raise DataError(f"{len(campaigns)} set-up is nothing to join", remedy="name at least two")
    if replace(options, band_hz=None) != Options():
        raise IdentificationError(
            "of the options of an identification, only the band goes with the responses alone",
            remedy="leave out method, order, refine, and what is to be picked or dropped",
        )
    require_distinct(campaigns)
    names = setup_names(campaigns)
    models = tuple(
        identify_responses(campaign, test, options.band_hz, method).identified[0].model for campaign in campaigns
    )
    setups = [_setup(n, m, c.rig) for n, m, c in zip(names, models, campaigns, strict=True)]
    joined = join_responses(setups)
    rig = _joined_rig([c.rig for c in campaigns], joined.freedoms)
    model = _model(models, names, joined, rig)
    campaign = Campaign(rig, (), (), common_provenance(campaigns), campaigns[0].source)
    result = Result((Identified(model.test or "random", model, None),), ())
    return JoinedAlone(result, campaign, models, _readings(setups, joined))


def _freedom(channel: Channel, rig: Rig) -> Freedom:
    if channel.point is None:
        raise DataError(
            f"channel {channel.name} has no point: set-ups are joined by the points of sensors that stay",
            where=rig.name,
            remedy="give every response its point in the rig file",
        )
    return channel.point, channel.direction[1]


def _sense(channel: Channel, rig: Rig) -> float:
    # What reads along the drive has been turned to its sense already.
    across = channel.direction[1] != rig.drive_direction[1]
    return -1.0 if across and channel.direction[0] == "-" else 1.0


def _setup(name: str, model: ModalModel, rig: Rig) -> ResponseSetUp:
    shapes, sigma = model.operating_shapes, model.operating_shape_sigma
    assert shapes is not None
    freedoms = [_freedom(c, rig) for c in rig.responses]
    # Of two sensors at one freedom the first stands for it.
    first = [freedoms.index(f) for f in dict.fromkeys(freedoms)]
    sense = np.array([_sense(c, rig) for c in rig.responses])
    unknown: NDArray[np.float64] = np.full(shapes.shape, np.nan)
    return ResponseSetUp(
        name,
        tuple(freedoms[k] for k in first),
        model.frequency_hz,
        model.frequency_sigma_hz,
        model.damping_ratio,
        model.damping_sigma,
        (shapes * sense)[:, first],
        (unknown if sigma is None else sigma)[:, first],
    )


def _joined_rig(rigs: Sequence[Rig], freedoms: Sequence[Freedom]) -> Rig:
    """The first rig with the points of all, and a channel for every freedom."""
    seen: dict[Freedom, Channel] = {}
    for rig in rigs:
        for channel in rig.responses:
            freedom = _freedom(channel, rig)
            along = {"direction": f"+{freedom[1]}"} if freedom[1] != rig.drive_direction[1] else {}
            renamed = {"name": joined_name(channel.name, channel.point), "input": ""} | along
            seen.setdefault(freedom, channel.model_copy(update=renamed))
    points = {p.id: p for rig in reversed(rigs) for p in rig.points}
    force = () if rigs[0].force is None else (rigs[0].force,)
    channels = [c.model_copy(update={"index": n}) for n, c in enumerate([*force, *(seen[f] for f in freedoms)])]
    lines = tuple(dict.fromkeys(line for rig in rigs for line in rig.lines))
    update = {
        "channels": tuple(channels),
        "points": tuple(sorted(points.values(), key=lambda p: p.id)),
        "lines": lines,
        "synchronisation": None,
    }
    return Rig.model_validate(rigs[0].model_copy(update=update).model_dump())


def _model(models: Sequence[ModalModel], names: Sequence[str], joined: JoinedResponses, rig: Rig) -> ModalModel:
    modes, outputs = joined.shapes.shape
    nothing = np.zeros((modes, outputs, 0))
    unshared = {name: m.n_modes - modes for name, m in zip(names, models, strict=True) if m.n_modes > modes}
    return models[0].model_copy(
        update={
            "band_hz": (max(m.band_hz[0] for m in models), min(m.band_hz[1] for m in models)),
            "frequency_hz": joined.frequency[0],
            "frequency_sigma_hz": joined.frequency[1],
            "damping_ratio": joined.damping[0],
            "damping_sigma": joined.damping[1],
            "outputs": tuple(c.name for c in rig.responses),
            "output_points": tuple(c.point for c in rig.responses),
            "modal_constants": nothing.astype(np.complex128),
            "modal_constant_sigma": nothing,
            "residuals": np.zeros((0, outputs, 0)),
            "half_power": np.full(modes, np.nan),
            "half_power_floor": np.full(modes, np.nan),
            "operating_shapes": joined.shapes,
            "operating_shape_sigma": joined.shape_sigma,
            "notes": (
                *dict.fromkeys(note for m in models for note in m.notes),
                f"Joined from the set-ups {', '.join(names)} by the sensors that stay.",
                *(
                    f"set-up {name}: {count} of its modes are not in every set-up, and not in the joined model"
                    for name, count in unshared.items()
                ),
            ),
        }
    )


def _readings(setups: Sequence[ResponseSetUp], joined: JoinedResponses) -> tuple[SetUpReading, ...]:
    return tuple(
        SetUpReading(
            item.name,
            item.frequency_hz[at],
            item.frequency_sigma_hz[at],
            item.damping_ratio[at],
            item.damping_sigma[at],
            np.abs(item.frequency_hz[at] - joined.frequency[0]) > FAR * item.frequency_sigma_hz[at],
            setups[0].name,
        )
        for item, at in zip(setups, joined.places, strict=True)
    )
