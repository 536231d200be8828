"""What the gap behaves like if it is in one channel: a linear operator first, then lost samples or a static curve."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block
from modallab.core.effect import LearnedElement, OneChannel
from modallab.gap.conditioning.prepare import PreparedCampaign
from modallab.gap.conditioning.reduce import reduce_blocks
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.baseline import baseline
from modallab.gap.model.fit import Fit, all_rows
from modallab.gap.model.forward import forward
from modallab.gap.report.initial_gap import problem_of_records, weights_of
from modallab.gap.search.fitting import Bench, complete_fit
from modallab.gap.unknown.curve import ForceCurve, curve_of, refined
from modallab.gap.unknown.description import Description
from modallab.gap.unknown.fitted import ElementTrial, element
from modallab.gap.unknown.sample_hold import hold_of
from modallab.gap.unknown.volts import ChannelOperator, channel_of, without_operator

LINEAR = (("gain",), ("low_pass_hz",), ("high_pass_hz",), ("gain", "delay"), ("mount_hz", "mount_zeta"))
"""Terms of an operator on one channel that are tried together."""
LEFT = 0.003
"""Relative model error that is forgiven while a twin meets the channel again that it was fitted without."""


def linear_operators(bench: Bench, row: int) -> Iterator[ElementTrial]:
    """Linear operators on one channel."""
    for names in LINEAR:
        yield ElementTrial(element(bench, "row_filter", names, OneChannel(channel=row)))


def fit_without_channel(bench: Bench, prepared: PreparedCampaign, fitted: Sequence[Block], row: int) -> Fit:
    """The twin as the other channels have it."""
    masked = prepared.masked | {(b.name, row) for b in prepared.blocks}
    return baseline(problem_of_records(replace(prepared, masked=frozenset(masked)), fitted, bench.free, bench.allowed))


def sample_operators(
    bench: Bench, prepared: PreparedCampaign, alone: Fit, held: Iterable[str], row: int
) -> Iterator[Description]:
    """Operators on one channel that must be looked at sample by sample.

    Args:
        bench: what is searched.
        prepared: the campaign.
        alone: the twin as the other channels have it.
        held: records that no fit may see.
        row: the channel.
    """
    prepared = _with_least_noise(prepared, row)
    unseen = set(held)
    fitted = [b for b in prepared.blocks if b.name not in unseen]
    channel = channel_of(prepared, alone.problem.twin(alone.u), row)
    lost = hold_of(channel, float(prepared.noise_v[row]))
    if lost is not None:
        spread = 1.96 * lost.spread
        learned = LearnedElement(
            element="row_hold",
            parameters={"share": lost.share, "kept": lost.kept},
            interval={"share": (max(lost.share - spread, 0.0), lost.share + spread)},
            place=OneChannel(channel=row),
        )
        yield _with_channel(bench, prepared, alone, channel, lost.made, learned, unseen)
    curve, interval = _curve(prepared, alone, channel, fitted)
    learned = LearnedElement(
        element="row_curve", parameters=curve.law, interval=dict(interval), place=OneChannel(channel=row)
    )
    yield _with_channel(bench, prepared, alone, channel, curve.made(channel), learned, unseen)


def _with_least_noise(prepared: PreparedCampaign, row: int) -> PreparedCampaign:
    """The campaign with one channel's sines in it even where they are flat, and with the noise it has at its calmest.

    What an operator makes of the samples would count as noise, or be left out with what it has cut.
    """
    noise = prepared.noise_v.copy()
    # A noise of exactly 0 is hidden in the converter's step: it was not measured.
    if prepared.measured_v[row] > 0:
        noise[row] = min(noise[row], prepared.measured_v[row])
    cut = {name for c in prepared.clipped if c.row == row for name in c.records}
    back = {(b.name, row) for b in prepared.blocks if b.test == "sine" and b.name in cut}
    return replace(prepared, noise_v=noise, masked=prepared.masked - back)


def _curve(
    prepared: PreparedCampaign, alone: Fit, channel: ChannelOperator, fitted: Sequence[Block]
) -> tuple[ForceCurve, dict[str, tuple[float, float]]]:
    """The channel's static curve with the intervals of its numbers."""
    used = [b for b in fitted if (b.name, channel.row) not in prepared.masked]
    # A twin predicts sines sample by sample, of hits no more than their lines.
    sines = [b for b in used if b.test == "sine"]
    begin = curve_of(channel, [b.name for b in sines or used])
    data = reduce_blocks(prepared.campaign, fitted, weights_of(prepared))
    answers = forward(alone.problem.twin(alone.u), data)
    at = data.channels.index(channel.row)

    def residual(curve: ForceCurve) -> Real:
        clean = reduce_blocks(
            prepared.campaign, without_operator(fitted, channel, curve.made(channel)), weights_of(prepared)
        )
        parts = [(r.y - y)[at] / r.sigma[at] for r, y in zip(all_rows(clean), answers, strict=True)]
        return np.concatenate([*(p.real for p in parts), *(p.imag for p in parts)])

    return refined(begin, residual)


def _with_channel(
    bench: Bench,
    prepared: PreparedCampaign,
    alone: Fit,
    channel: ChannelOperator,
    made: Mapping[str, Real],
    learned: LearnedElement,
    held: set[str],
) -> Description:
    """The twin with the channel once more, its records freed of what the operator does."""
    clean = replace(prepared, blocks=without_operator(prepared.blocks, channel, made))
    own = [b for b in clean.blocks if b.name not in held] or list(clean.blocks)
    again = problem_of_records(clean, own, bench.free, bench.allowed)
    fit = complete_fit(again, alone, LEFT)
    return Description(fit, _held_out(clean, held), _held_out(prepared, held), (learned,), (channel.row,))


def _held_out(prepared: PreparedCampaign, held: set[str]) -> Reduced:
    blocks = [b for b in prepared.blocks if b.name in held] or list(prepared.blocks)
    return reduce_blocks(prepared.campaign, blocks, weights_of(prepared))
