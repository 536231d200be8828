"""What the half-power rule reads, and why it is not the damping."""

from math import isfinite

import numpy as np

from modallab.core.digits import short_number, significant_digits
from modallab.reporting.compare import ComparedMode, ModeReading
from modallab.reporting.content import ReportContent
from modallab.reporting.figures.damping import damping_figure, half_power_reading, is_bench_of_paper, paper_value
from modallab.reporting.markup import Markup, html_element, join_markup
from modallab.reporting.sections.section import Section, captioned_figure, paragraph

BLURRED = 2.0
"""A reading below so many times the floor says more about the block than about the mode."""


def half_power_section(content: ReportContent, modes: tuple[ComparedMode, ...]) -> Section:
    """The damping figure with the explanation in words."""
    anchor, heading = "half-power", "What the half-power rule can see"
    if not modes:
        return Section(anchor, heading, None)
    if not any(isfinite(r.half_power_floor) for m in modes for r in m.readings):
        return Section(anchor, heading, None, ("The resolution of the half-power rule is not known for these data.",))
    seen = next((m for m in modes if _reading_of_block(m) is not None), None)
    paper = is_bench_of_paper(content.rig)
    texts = [_rule_in_words(content)]
    if seen is not None:
        texts += [_mode_in_words(seen, content.models[0].method), _paper_sentence(modes) if paper else ""]
    curve = _reading_curve(content, seen) if seen is not None else None
    figures = html_element("div", _overview_sentence(modes, paper), curve, class_="pair")
    return Section(anchor, heading, join_markup([*(paragraph(t) for t in texts if t), figures]))


def _reading_of_block(mode: ComparedMode) -> ModeReading | None:
    """What the rule read off a block: the sine test's reading comes from few frequencies, no block's spectrum."""
    fit = (r for r in mode.readings if r.test != "sine" and isfinite(r.half_power_floor) and isfinite(r.half_power))
    return next(fit, None)


def _overview_sentence(modes: tuple[ComparedMode, ...], papers: bool) -> Markup:
    paper = papers and any(paper_value(m) is not None for m in modes)
    triangles = (
        " The triangles are the paper's Table 1: each pair is one number, read as Δf/f (left) and as ζ (right)."
        if paper
        else ""
    )
    return captioned_figure(
        damping_figure(modes, papers),
        "damping",
        _alternative_text(modes),
        "Damping of each mode. The grey bar is the resolution. Inside the bar, a half-power reading shows the width "
        "of one line "
        "or step of the spectrum, not the damping of the beam: that reading is always near the end of the "
        f"bar.{triangles}",
        1,
    )


def _reading_curve(content: ReportContent, mode: ComparedMode) -> Markup | None:
    length = _block_s(content)
    reading = _reading_of_block(mode)
    if not length or reading is None:
        return None
    papers = is_bench_of_paper(content.rig) and paper_value(mode) is not None
    dotted = "; the dotted lines are the paper's Table 1, taken for Δf/f (lower) and for ζ (upper)" if papers else ""
    return captioned_figure(
        half_power_reading(mode, reading, length, _before_s(content), is_bench_of_paper(content.rig)),
        "resolution",
        f"Half-power reading of mode {mode.number} over the damping of the beam, with no window and with a Hann "
        "window; each curve is flat up to the resolution of the block and rises only then",
        f"What the half-power rule would read for mode {mode.number} for other damping of the beam. Where a "
        f"curve is flat, the rule reads the block and not the beam. The diamond is the reading in this test{dotted}.",
        1,
    )


def _before_s(content: ReportContent) -> float:
    hit = next((o.example for o in content.outcomes if o.test == "impact" and o.example is not None), None)
    return 0.0 if hit is None else int(np.argmax(np.abs(hit.force))) / hit.rate_hz


def _rule_in_words(content: ReportContent) -> str:
    length = _block_s(content)
    of = f"a block of {short_number(length)} s" if length else "a short block"
    step = f" ({significant_digits(1 / length, 3)} Hz)" if length else ""
    sine = (
        " In a sine test a peak cannot be narrower than the step between drive frequencies."
        if any(o.test == "sine" for o in content.outcomes)
        else ""
    )
    return (
        "The half-power rule takes damping from the width of a peak. "
        f"In {of} no peak can be narrower than about one line of the spectrum{step}. "
        f"If the structure still rings when the block ends, the rule measures the block.{sine}"
    )


def _mode_in_words(mode: ComparedMode, method: str) -> str:
    reading, best = _reading_of_block(mode), mode.best
    if reading is None:
        return ""
    read, floor, found = (
        significant_digits(100 * v, 2) for v in (reading.half_power, reading.half_power_floor, best.damping)
    )
    if reading.half_power > BLURRED * reading.half_power_floor:
        return (
            f"For mode {mode.number} the rule reads {read} %, well above its floor of {floor} %. "
            f"The identified damping is {found} %."
        )
    if method == "peak":
        return (
            f"This model was made by the half-power rule itself. It gives {read} % for mode {mode.number}; a mode "
            f"with no damping at all would give {floor} %. Take this damping as an upper limit."
        )
    return (
        f"For mode {mode.number} the rule reads {read} %. A mode with no damping at all would give {floor} %. "
        f"The identified damping is {found} %, from the same block, with its truncated ring-down modelled."
    )


def _paper_sentence(modes: tuple[ComparedMode, ...]) -> str:
    value = paper_value(modes[0])
    if value is None:
        return ""
    return (
        f"The paper this bench follows gives {100 * value:.2f} % for its first mode at 4.8 Hz, also by half-power "
        "from a block of 1.024 s. Two readings of that number are possible. If it is the relative width of the peak, "
        f"Δf/f, which is the usual loss factor η = 2ζ, then ζ = {50 * value:.2f} %: the floor of the rule with no "
        "window. If it is ζ itself, it is the floor with a Hann window, which makes every peak twice as wide. Either "
        f"way {100 * value:.1f} % is the resolution of the block and says nothing about the beam."
    )


def _block_s(content: ReportContent) -> float:
    blocks = content.campaign.of("impact") or content.campaign.blocks
    return blocks[0].duration_s if blocks else 0.0


def _alternative_text(modes: tuple[ComparedMode, ...]) -> str:
    rows = [
        f"mode {m.number}: identified {significant_digits(100 * m.best.damping, 2)} percent, half-power reading "
        f"{significant_digits(100 * m.readings[0].half_power, 2)} percent, floor "
        f"{significant_digits(100 * m.readings[0].half_power_floor, 2)} "
        "percent"
        for m in modes
    ]
    return "Damping of each mode on a logarithmic scale; " + "; ".join(rows)
