"""Where the gap lies: what tests on the residual say, and what the models that explain it add."""

from collections.abc import Sequence

from modallab.core.diagnosis import FoundEffect, GapLocation, Verdict
from modallab.core.digits import share_text
from modallab.core.effect import channels_of_place, x_m_of
from modallab.core.effects import Stage, kind_of
from modallab.gap.conditioning.prepare import PreparedCampaign
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.report.locate import ResidualTestsResult
from modallab.gap.report.measure import name_of_band, share_of_gap_closed, share_of_squares_within, shares_by_frequency
from modallab.gap.search.choose import Selection

MOSTLY = 0.8
"""Share of the squares that the bands named must hold."""


def gap_location(
    verdict: Verdict,
    found: Sequence[FoundEffect],
    withheld: Sequence[str],
    location: ResidualTestsResult | None,
    choice: Selection,
    data: Reduced,
    prepared: PreparedCampaign,
) -> GapLocation:
    """Where it lies.

    Args:
        verdict: of the diagnosis.
        found: effects judged present.
        withheld: effects the records show, whose names must not be used.
        location: of the residual, before any effect was fitted; None if the residual is flat.
        choice: what the search says.
        data: all records.
        prepared: the campaign.
    """
    if verdict == "no_gap":
        said = ["Only noise is left."]
        return GapLocation(stage=None, channels=[], x_m=None, tests=[], bands=[], share=0.0, why=said)
    stage, rows, tests, why = _stage_and_rows(verdict, found, withheld, location, choice, data, prepared)
    bands = _bands_of_gap(choice, data)
    rig = prepared.campaign.rig
    of_all = [r for r in rows if r in data.channels]
    return GapLocation(
        stage=stage,
        tested_stage=None if location is None else location.stage,
        channels=[rig.channels[r].name for r in rows],
        x_m=next((x for f in found if (x := x_m_of(f.place)) is not None), None) if verdict == "known" else None,
        tests=list(tests),
        bands=bands,
        share=share_of_squares_within(choice.base.problem.twin(choice.base.u), data, tests, of_all, bands),
        why=why,
    )


def _stage_and_rows(
    verdict: Verdict,
    found: Sequence[FoundEffect],
    withheld: Sequence[str],
    location: ResidualTestsResult | None,
    choice: Selection,
    data: Reduced,
    prepared: PreparedCampaign,
) -> tuple[Stage, list[int], Sequence[str], list[str]]:
    """Stage, rows, tests and the reasons."""
    force = prepared.campaign.rig.force_channel.index
    lead = max(found, key=lambda f: f.probability) if found and verdict == "known" else None
    if lead is not None:
        rows = sorted({r for f in found for r in _rows_of(f, force, data.channels)})
        tests = sorted({t for f in found for t in kind_of(f.effect).tests})
        return lead.stage, rows, tests, _reasons_of_place(lead, location, choice)
    if location is not None:
        return location.stage, list(location.channels), location.tests, list(location.why)
    kind = kind_of(withheld[0])
    rows = [*prepared.noisy, *(c.row for c in prepared.clipped)]
    return kind.stage, rows, kind.tests, ["The records show the effect without any model."]


def _reasons_of_place(lead: FoundEffect, location: ResidualTestsResult | None, choice: Selection) -> list[str]:
    if location is None:
        return ["The records show the effect without any model."]
    if location.stage == lead.stage or not choice.fit.problem.candidates:
        return list(location.why)
    residual_says = f"Tests on the residual indicated the {location.stage}: {' '.join(location.why)}"
    explained = share_of_gap_closed(choice.base.gap, choice.fit.gap)
    other = [f for f in choice.rivals if kind_of(f.problem.candidates[-1].effect).stage != lead.stage]
    best = max((share_of_gap_closed(choice.base.gap, f.gap) for f in other), default=0.0)
    return [
        f"Models of the {lead.stage} explain {share_text(explained)} of the gap, those of other stages no more than "
        f"{share_text(max(best, 0.0))}.",
        residual_says,
    ]


def _rows_of(found: FoundEffect, force: int, channels: tuple[int, ...]) -> list[int]:
    rows = channels_of_place(found.place)
    if kind_of(found.effect).place == "force":
        return [force]
    if isinstance(rows, int):
        return [rows]
    return list(channels if rows == "all" else rows or ())


def _bands_of_gap(choice: Selection, data: Reduced) -> list[tuple[float, float]]:
    shares = shares_by_frequency(choice.base.problem.twin(choice.base.u), data, name_of_band)
    held: list[tuple[float, float]] = []
    total = 0.0
    for name, share in sorted(shares.items(), key=lambda kv: -kv[1]):
        if total > MOSTLY:
            break
        low, _, high = name.partition("-")
        held.append((float(low), float(high) if high else 1e4))
        total += share
    return sorted(held)
