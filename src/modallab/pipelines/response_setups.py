"""Identifies several set-ups of responses alone, and joins them by the fixed sensors."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real
from modallab.core.block import Campaign
from modallab.core.errors import DataError, IdentificationError
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Rig
from modallab.core.units import Test
from modallab.identification.options import USUAL_RESPONSE, IdentificationOptions, ResponseMethod
from modallab.identification.response_only.known_poles import shapes_at
from modallab.identification.setups.found import joined_name
from modallab.identification.setups.join_responses import Freedom, JoinedResponses, ResponseSetUp, join_responses
from modallab.identification.setups.readings import SetUpReading
from modallab.pipelines.identify import CampaignResult, IdentifiedTest
from modallab.pipelines.response_only import identify_responses, response_records
from modallab.pipelines.setups import common_provenance, require_distinct, setup_names
from modallab.verification.assessment import assess_model

FAR = 4.0
"""Sigmas by which a set-up's frequency is off the joined one."""


@dataclass(frozen=True, eq=False, slots=True)
class JoinedResponseSetUps:
    """Several set-ups of responses alone as one.

    Attributes:
        result: the joined model.
        campaign: the joined outputs as a rig, without records, which are those of the set-ups.
        models: of the set-ups.
        readings: what each set-up read of the joined modes.
    """

    result: CampaignResult
    campaign: Campaign
    models: tuple[ModalModel, ...]
    readings: tuple[SetUpReading, ...]


def identify_response_setups(
    campaigns: Sequence[Campaign],
    options: IdentificationOptions,
    test: Test | None = None,
    method: ResponseMethod = USUAL_RESPONSE,
) -> JoinedResponseSetUps:
    """One model of the responses of several set-ups.

    Args:
        campaigns: one a set-up, each with the rig as its sensors stood then.
        options: of which only the band applies to the responses alone.
        test: only this test's records.
        method: how modes are found.

    Raises:
        DataError: fewer than two set-ups, one of them twice, a sensor without a point, or nothing that joins them.
        IdentificationError: a set-up has no mode, no mode is in most of them, or options that have no place here.
    """
    if len(campaigns) < 2:
        raise DataError(f"{len(campaigns)} set-up cannot be joined", remedy="name at least two")
    if replace(options, band_hz=None) != IdentificationOptions():
        raise IdentificationError(
            "of the options of an identification, only the band applies to the responses alone",
            remedy="leave out method, order, refine, and picked or dropped modes",
        )
    require_distinct(campaigns)
    names = setup_names(campaigns)
    found = [identify_responses(campaign, test, options.band_hz, method).identified[0] for campaign in campaigns]
    models = tuple(item.model for item in found)
    rigs = [c.rig.of_outputs(m.outputs) for c, m in zip(campaigns, models, strict=True)]
    setups = [_setup_of_model(*one) for one in zip(names, models, rigs, strict=True)]

    def look(n: int, frequency_hz: Real, damping_ratio: Real) -> tuple[Complex128, Real]:
        records, rate, *_ = response_records(campaigns[n], test)
        rows, sense = _outputs_by_freedom(rigs[n])
        values, sigma = shapes_at(records, rate, models[n].band_hz, frequency_hz, damping_ratio)
        return (values * sense)[:, rows], sigma[:, rows]

    joined = join_responses(setups, look)
    read = _setup_readings(setups, joined)
    rig = _joined_rig(rigs, joined.freedoms)
    model = _joined_model(models, read, joined, rig)
    campaign = Campaign(rig, (), (), common_provenance(campaigns), campaigns[0].source)
    each = [values_at_modes(item.assessment.confidence if item.assessment else np.full(item.model.n_modes, np.nan), at)
            for item, at in zip(found, joined.places, strict=True)]  # fmt: skip
    sure = np.nan_to_num(np.array(each)).mean(axis=0)
    result = CampaignResult(
        (IdentifiedTest(model.test or "random", model, None, assess_model(model, (), (), sure)),), ()
    )
    return JoinedResponseSetUps(result, campaign, models, read)


def _freedom_of_channel(channel: Channel, rig: Rig) -> Freedom:
    if channel.point is None:
        raise DataError(
            f"channel {channel.name} has no point: set-ups are joined by the points of fixed sensors",
            where=rig.name,
            remedy="give every response its point in the rig file",
        )
    return channel.point, channel.direction[1]


def _outputs_by_freedom(rig: Rig) -> tuple[list[int], Real]:
    """The outputs that stand for their freedoms, the first of those at one, and the sense of every output."""
    freedoms = [_freedom_of_channel(c, rig) for c in rig.responses]
    return [freedoms.index(f) for f in dict.fromkeys(freedoms)], np.array([rig.sense_of(c) for c in rig.responses])


def _setup_of_model(name: str, model: ModalModel, rig: Rig) -> ResponseSetUp:
    shapes, sigma = model.operating_shapes, model.operating_shape_sigma
    assert shapes is not None
    first, sense = _outputs_by_freedom(rig)
    unknown: Real = np.full(shapes.shape, np.nan)
    return ResponseSetUp(
        name,
        tuple(_freedom_of_channel(rig.responses[k], rig) for k in first),
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
            freedom = _freedom_of_channel(channel, rig)
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


def _joined_model(
    models: Sequence[ModalModel], read: Sequence[SetUpReading], joined: JoinedResponses, rig: Rig
) -> ModalModel:
    modes, outputs = joined.shapes.shape
    nothing = np.zeros((modes, outputs, 0))
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
                f"Joined from the set-ups {', '.join(item.name for item in read)} by the fixed sensors.",
                *_lacking_modes_note(joined, read),
                *_left_out_note(models, joined, read),
                *_differing_setups_note(joined, read),
            ),
        }
    )


def _lacking_modes_note(joined: JoinedResponses, read: Sequence[SetUpReading]) -> Iterator[str]:
    for r, places in enumerate(joined.places.T):
        lacking = [item.name for item, at in zip(read, places, strict=True) if at < 0]
        if lacking:
            yield (
                f"mode {r + 1} ({joined.frequency[0, r]:.4g} Hz) was not found in set-up {', '.join(lacking)} by "
                "itself; its shape there was fitted at that frequency and damping"
            )


def _left_out_note(
    models: Sequence[ModalModel], joined: JoinedResponses, read: Sequence[SetUpReading]
) -> Iterator[str]:
    for model, places, item in zip(models, joined.places, read, strict=True):
        alone = np.delete(model.frequency_hz, places[places >= 0])
        if alone.size:
            listed = ", ".join(f"{f:.4g}" for f in alone)
            yield f"set-up {item.name}: {listed} Hz is in few set-ups, and not in the joined model"


def _differing_setups_note(joined: JoinedResponses, read: Sequence[SetUpReading]) -> Iterator[str]:
    for item in read:
        if item.off.any():
            away = np.where(item.off, np.abs(item.frequency_hz / joined.frequency[0] - 1), 0.0)
            r = int(np.argmax(away))
            side = "higher" if item.frequency_hz[r] > joined.frequency[0, r] else "lower"
            yield (
                f"set-up {item.name} is off: mode {r + 1} is {100 * away[r]:.2g} % {side} than in the median of the "
                "set-ups, by more than its sigma explains. The scatter between set-ups is in the sigmas."
            )


def _setup_readings(setups: Sequence[ResponseSetUp], joined: JoinedResponses) -> tuple[SetUpReading, ...]:
    read = [
        [values_at_modes(v, at) for v in (s.frequency_hz, s.frequency_sigma_hz, s.damping_ratio, s.damping_sigma)]
        for s, at in zip(setups, joined.places, strict=True)
    ]
    middle = np.nanmedian([f for f, *_ in read], axis=0)
    return tuple(
        SetUpReading(item.name, f, sigma, zeta, zeta_sigma, np.abs(f - middle) > FAR * sigma, setups[0].name)
        for item, (f, sigma, zeta, zeta_sigma) in zip(setups, read, strict=True)
    )


def values_at_modes(values: Real, places: NDArray[np.int64]) -> Real:
    """(modes,) what stands at these places; NaN where a set-up has none."""
    return np.where(places >= 0, values[places], np.nan)
