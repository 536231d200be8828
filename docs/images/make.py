"""Draws the pictures of the pages from a campaign of the demo, with the figures of its report.

modallab demo --out demo
python docs/images/make.py demo docs/images
"""

import argparse
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure

from modallab.core.block import Campaign
from modallab.core.frf import Frf
from modallab.core.model import Verification
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.report import modes_as_built, report_content
from modallab.reporting.compare import matched_modes
from modallab.reporting.content import OutcomeOfTest
from modallab.reporting.figures import style
from modallab.reporting.figures.damping import damping_figure, half_power_reading
from modallab.reporting.figures.mobility import mobility_panels
from modallab.reporting.figures.mode_shapes import mode_shapes

PAPER_BAND = (3.0, 110.0)
SHOWN = (3, 6, 10)
"""Points that are enough to see the three modes."""


def main() -> None:
    """Read the campaign, identify the paper's three modes, write one SVG a picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("campaign", type=Path, help="folder or file of a demo's campaign")
    parser.add_argument("out", type=Path, help="folder for the pictures")
    arguments = parser.parse_args()
    for name, figure in pictures(read_campaign(arguments.campaign)).items():
        write(figure, arguments.out / f"{name}.svg", name)


def pictures(campaign: Campaign) -> dict[str, Figure]:
    """The pictures by name."""
    content = report_content(campaign, identify_campaign(campaign, IdentificationOptions(band_hz=PAPER_BAND)), "")
    models = list(content.models)
    found = matched_modes(models, modes_as_built(campaign))
    impact = next(o for o in content.outcomes if o.test == "impact")
    shapes = mode_shapes(models, campaign.rig)
    if impact.verification is None or shapes is None:
        raise SystemExit("the campaign is none of the demo: it has no impact test, or no shapes")
    return {
        "mobility": mobility_panels(at_points(impact.verification, SHOWN)),
        "mode-shapes": shapes,
        "damping": damping_figure(found),
        "half-power": half_power_reading(
            found[0], found[0].readings[0], campaign.of("impact")[0].duration_s, hit_s(impact)
        ),
    }


def hit_s(outcome: OutcomeOfTest) -> float:
    """Time before the hit in the test's example block."""
    signals = outcome.example
    return 0.0 if signals is None else int(abs(signals.force).argmax()) / signals.rate_hz


def at_points(check: Verification, points: tuple[int, ...]) -> Verification:
    """The verification of some points only."""
    rows = [check.measured.output_points.index(point) for point in points]

    def part(frf: Frf) -> Frf:
        names = tuple(frf.outputs[row] for row in rows)
        return replace(frf, values=frf.values[rows], outputs=names, output_points=points, coherence=None, variance=None)

    return Verification(part(check.measured), part(check.regenerated), part(check.untruncated), check.frac[rows])


def write(figure: Figure, path: Path, name: str) -> None:
    """One SVG, the same in every run."""
    with style.figure_style(), mpl.rc_context({"svg.hashsalt": name, "svg.fonttype": "path"}):
        legend_above(figure)
        figure.savefig(path, format="svg", bbox_inches="tight", metadata={"Date": None, "Creator": None})


def legend_above(figure: Figure) -> None:
    """The legend in as many columns as the figure is wide; in a report it is text, and breaks by itself."""
    old = figure.legends[0]
    labels = [text.get_text() for text in old.get_texts()]
    handles = old.legend_handles
    old.remove()
    columns = int(figure.get_size_inches()[0] * style.PX_PER_INCH // 210)
    figure.legend(handles, labels, loc="lower left", bbox_to_anchor=(0, 0.93), ncols=columns, handlelength=2.2)


if __name__ == "__main__":
    main()
