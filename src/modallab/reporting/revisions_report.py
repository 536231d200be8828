"""How a simulation came closer to its bench: a curve over its revisions, as a page and in the gap's report."""

from collections.abc import Sequence
from math import log10
from pathlib import Path

from modallab.core.digits import three_digits
from modallab.core.rig import Rig
from modallab.formats.atomic import write_text
from modallab.gap.revisions import RevisionStep
from modallab.reporting.gap_candidates import captioned_picture, page_section, whole_page
from modallab.reporting.markup import Markup, html_element, html_table

WIDTH, HEIGHT = 760, 240
CAPTION = (
    "The gap of each revision of the simulation in noise units, on a logarithmic scale; 1 is noise. The first "
    "curve is the gap at each diagnosis, on held-out records. The others are the gap of every revision on all records "
    "of one campaign."
)


def write_revisions_report(path: Path, rig: Rig, steps: Sequence[RevisionStep]) -> None:
    """Write the page. The file is whole or, after an error, as it was before.

    Raises:
        StorageError: the file can't be written.
    """
    text = whole_page(f"Revisions of {rig.name}", CAPTION, revisions_section(steps))
    write_text(path, text)


def revisions_section(steps: Sequence[RevisionStep]) -> Markup:
    """The curve, and its numbers as a table."""
    names = list(steps[0].measured)
    rows = [
        [
            str(s.number),
            s.effects,
            "" if s.gap is None else three_digits(s.gap),
            *(f"{s.measured[n]:.3g}" for n in names),
        ]
        for s in steps
    ]
    head = ["revision", "with", "when applied", *names]
    numbers = html_table("Gap of each revision, noise units", head, rows, numeric=tuple(range(2, len(head))))
    return page_section("Progress of the simulation", captioned_picture(revision_curve(steps), CAPTION), numbers)


def revision_curve(steps: Sequence[RevisionStep]) -> Markup:
    """The gap over the revisions, a line for each way it was measured."""
    names = list(steps[0].measured)
    lines = [[s.gap for s in steps], *([s.measured[n] for s in steps] for n in names)]
    top = max([v for line in lines for v in line if v is not None] + [10.0])

    def at(number: int, gap: float) -> tuple[float, float]:
        return 70 + 600 * number / max(len(steps) - 1, 1), 200 - 180 * log10(max(gap, 1.0)) / log10(top)

    parts: list[Markup] = [_draw_axis(200, "1"), _draw_axis(20, three_digits(top))]
    for line, colour in zip(lines, ("second", "measured", "model", "warning", "ink"), strict=False):
        points = [at(number, gap) for number, gap in enumerate(line) if gap is not None]
        joined = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        parts.append(html_element("polyline", points=joined, fill="none", stroke=f"var(--{colour})", stroke_width="2"))
        parts += [
            html_element("circle", cx=f"{x:.1f}", cy=f"{y:.1f}", r="4", fill=f"var(--{colour})") for x, y in points
        ]
    for step in steps:
        x, _ = at(step.number, 1.0)
        parts.append(
            html_element("text", str(step.number), x=f"{x:.1f}", y="222", text_anchor="middle", fill="var(--ink)")
        )
    return html_element(
        "svg",
        *parts,
        viewBox=f"0 0 {WIDTH} {HEIGHT}",
        width="100%",
        role="img",
        aria_label="The gap over the revisions of the simulation",
    )


def _draw_axis(y: float, number: str) -> Markup:
    label = html_element("text", number, x="60", y=f"{y + 5:.0f}", text_anchor="end", fill="var(--ink)", font_size="13")
    line = html_element("line", x1="70", y1=f"{y:.0f}", x2="670", y2=f"{y:.0f}", stroke="var(--soft)")
    return html_element("g", label, line)
