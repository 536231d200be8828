"""Blind trials as a page: figures, confusion, reliability, shrinkage, and every miss by name."""

from collections.abc import Sequence

from modallab.blind.outcome import BlindOutcome, EffectOutcome, OutcomeFigure, ShrinkageOutcome
from modallab.core.digits import percent_text, share_text
from modallab.reporting.gap_candidates import captioned_picture, page_section, whole_page
from modallab.reporting.markup import Markup, html_element, html_table

SIDE = 320
EDGE = 40


def render(found: BlindOutcome) -> str:
    """The whole page as text."""
    sealed = f"Their truths were sealed before the first answer, SHA-256 {found.sealed}. " if found.sealed else ""
    caption = f"{found.trials} campaigns were diagnosed without their truth. {sealed}Answers: SHA-256 {found.answers}."
    return whole_page(
        "Blind trials of the diagnosis",
        caption,
        _figures_table(found.figures),
        _effects_table(found.effects),
        _confusion_table(found.effects),
        _reliability(found),
        _shrinkage(found.shrinkage),
    )


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"


def _figures_table(figures: Sequence[OutcomeFigure]) -> Markup:
    rows = [[f.name, _number(f.value), str(f.count), ", ".join(f.misses)] for f in figures]
    head = ["figure", "value", "of", "missed"]
    return page_section("Figures", html_table("Figures of all trials", head, rows, numeric=(1, 2)))


def _effects_table(effects: Sequence[EffectOutcome]) -> Markup:
    head = ["true effect", "trials", "right", "stage", "parameter off by", "gap closed", "later off by"]
    rows = [
        [
            e.effect.replace("_", " "),
            str(e.trials),
            str(e.right),
            "" if e.stage is None else str(e.stage),
            "" if e.parameter is None else percent_text(e.parameter),
            "" if e.closed is None else share_text(e.closed),
            _number(e.shrink_error),
        ]
        for e in effects
    ]
    return page_section("Effect by effect", html_table("Medians over trials", head, rows, numeric=(1, 2, 3, 4, 5, 6)))


def _confusion_table(effects: Sequence[EffectOutcome]) -> Markup:
    caption = list(dict.fromkeys(name for e in effects for name in e.said))
    rows = [[e.effect.replace("_", " "), *(str(e.said.get(name, "")) for name in caption)] for e in effects]
    head = ["true", *(name.replace("_", " ") for name in caption)]
    numbers = tuple(range(1, len(head)))
    return page_section(
        "Diagnosis of each effect",
        html_element("div", html_table("Trials", head, rows, numeric=numbers), class_="scroll"),
    )


def _reliability(found: BlindOutcome) -> Markup | None:
    points = [(float(s.name.removeprefix("said ")), s.value) for s in found.reliability if s.value is not None]
    if not points:
        return None
    caption = (
        f"Stated probability, and share of right names; both are equal on the line. Calibration "
        f"error {found.calibration_error:.3f}."
    )
    return page_section("Reliability", captioned_picture(_square_plot(points, "said", "right", 0.0), caption))


def _shrinkage(shrinkage: Sequence[ShrinkageOutcome]) -> Markup | None:
    if not shrinkage:
        return None
    caption = (
        "Share of the gap that a diagnosis closes: as predicted, on held-out records, and as measured in a "
        "later campaign on the same bench, with the effect in the simulation. Values below -1 are drawn at -1."
    )
    points = [(s.predicted, s.seen) for s in shrinkage]
    return page_section("Shrinkage", captioned_picture(_square_plot(points, "predicted", "seen", -1.0), caption))


def _square_plot(points: Sequence[tuple[float, float]], along: str, up: str, low: float) -> Markup:
    def at(value: float) -> float:
        return SIDE * (min(max(value, low), 1.0) - low) / (1.0 - low)

    def text(x: float, y: float, caption: str, anchor: str) -> Markup:
        return html_element(
            "text", caption, x=f"{x:g}", y=f"{y:g}", text_anchor=anchor, font_size="13", fill="var(--ink)"
        )

    frame = html_element(
        "rect", x=str(EDGE), y="10", width=str(SIDE), height=str(SIDE), fill="none", stroke="var(--soft)"
    )
    same = html_element("line", x1=str(EDGE), y1=str(SIDE + 10), x2=str(SIDE + EDGE), y2="10", stroke="var(--soft)")
    dots = [
        html_element("circle", cx=f"{EDGE + at(x):.1f}", cy=f"{SIDE + 10 - at(y):.1f}", r="4", fill="var(--second)")
        for x, y in points
    ]
    words = [
        text(EDGE + SIDE / 2, SIDE + 34, along, "middle"),
        text(EDGE - 6, 20, f"{up} 1", "end"),
        text(EDGE - 6, SIDE + 10, f"{low:g}", "end"),
    ]
    return html_element(
        "svg", frame, same, *dots, *words, viewBox=f"0 0 {SIDE + 2 * EDGE} {SIDE + EDGE}", width="420", role="img",
        aria_label=f"{up} against {along}",
    )  # fmt: skip
