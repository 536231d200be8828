"""What was measured: one block of each test, every hit, all FRFs."""

from modallab.core.digits import count_with_noun, significant_digits
from modallab.core.units import Test
from modallab.reporting.content import OutcomeOfTest, ReportContent
from modallab.reporting.figures.blocks import hits_figure, impact_block, sine_block
from modallab.reporting.figures.mobility import frf_overview
from modallab.reporting.figures.mode_shapes import farthest_sensor
from modallab.reporting.markup import Markup, html_element, html_table, join_markup
from modallab.reporting.sections.section import Section, captioned_figure


def signals_section(content: ReportContent) -> Section:
    """Signals in time and as spectrum, hits and FRFs of each test."""
    tests: tuple[Test, ...] = ("sine", "impact")
    there = {o.test for o in content.outcomes}
    absent = [f"There is no {test} test in this campaign." for test in tests if test not in there]
    parts: list[Markup] = []
    for i, outcome in enumerate(content.outcomes):
        shown = _example_record(content, outcome) + _hits_part(outcome) + _frfs_part(outcome, i)
        if shown:
            parts += [html_element("h3", f"The {outcome.test} test" if outcome.test else "The FRFs"), *shown]
        absent += _absent_note(outcome)
    return Section("signals", "What was measured", join_markup(parts) if parts else None, tuple(absent))


def _absent_note(outcome: OutcomeOfTest) -> list[str]:
    name = f"the {outcome.test} test" if outcome.test else "the FRFs"
    out = []
    if outcome.example is None and outcome.test is not None:
        out.append(f"There are no time signals to draw for {name}.")
    if outcome.frf is not None and outcome.frf.coherence is None:
        out.append(f"There is no coherence for {name}: coherence needs an average over several blocks.")
    return out


def _example_record(content: ReportContent, outcome: OutcomeOfTest) -> list[Markup]:
    signals = outcome.example
    if signals is None:
        return []
    output = farthest_sensor(content.rig, signals.outputs)
    to_hz = 2 * outcome.model.band_hz[1] if outcome.model else signals.rate_hz / 2
    block = signals.block
    if block.test != "impact":
        at = f" at {block.frequency_hz:.2f} Hz" if block.frequency_hz else ""
        figure = sine_block(signals, output, content.rig, to_hz)
        caption = f"Force and response in time and as amplitude spectrum{at} (record {block.name})."
        return [
            captioned_figure(
                figure, "sine", f"Force and response of one {block.test} block{at}, in time and as spectrum", caption
            )
        ]
    figure = impact_block(signals, output, content.rig, outcome.filtered, to_hz)
    dashed = " The dashed line is the response after the band-pass filter." if outcome.filtered is not None else ""
    caption = f"Force and response in time and as amplitude spectrum (record {block.name}).{dashed}"
    return [captioned_figure(figure, "impact", "Force and response of one hit, in time and as spectrum", caption)]


def _hits_part(outcome: OutcomeOfTest) -> list[Markup]:
    if not outcome.hits:
        return []
    band = outcome.model.band_hz if outcome.model else (3.0, 110.0)
    rejected = [h for h in outcome.hits if not h.accepted]
    good = len(outcome.hits) - len(rejected)
    text = f"{count_with_noun(good, 'hit')} counted, {len(rejected)} rejected."
    figure = captioned_figure(
        hits_figure(outcome.hits, band),
        "hits",
        f"Force pulses of all hits and their spectra. {text}",
        f"Every hit of the hammer. {text} A good hit is one short pulse whose spectrum stays high over the whole band.",
    )
    rows = [
        (
            h.name,
            "not given" if h.point is None else str(h.point),
            significant_digits(float(abs(h.force_n).max()), 3),
            h.reason,
        )
        for h in rejected
    ]
    listing = html_table("Rejected hits", ("record", "point", "peak force [N]", "why"), rows, (2,)) if rows else None
    return [figure] + ([listing] if listing else [])


def _frfs_part(outcome: OutcomeOfTest, place: int) -> list[Markup]:
    frf = outcome.frf
    if frf is None:
        return []
    name = f"{outcome.test} test" if outcome.test else "Imported FRFs"
    modes = outcome.model.frequency_hz if outcome.model else None
    seen = " and their coherence" if frf.coherence is not None else ""
    drives = len(frf.input_points)
    more = f" Drawn for the first of {drives} drive points." if drives > 1 else ""
    figure = captioned_figure(
        frf_overview(frf, 0, modes),
        f"overview-{place}",
        f"Amplitude of the {frf.quantity} of {count_with_noun(len(frf.outputs), 'sensor')} over frequency{seen}",
        f"All FRFs of the {name}{seen}. Dotted lines mark the identified modes.{more}",
    )
    return [figure]
