"""The mode shapes, moving and with their uncertainty; how alike those of two tests are."""

from itertools import combinations, pairwise

from modallab.core.digits import four_places
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.reporting.content import OutcomeOfTest, ReportContent
from modallab.reporting.figures.animation import animated_shapes
from modallab.reporting.figures.mode_shapes import beam_shape, mode_shapes
from modallab.reporting.figures.wireframe import is_spatial, moving_wireframes, shapes_of_model
from modallab.reporting.markup import Markup, html_element, html_table, join_markup
from modallab.reporting.sections.section import Section, captioned_figure, paragraph
from modallab.verification.comparison import ShapeComparison, compare_shapes

OUT_OF_STEP_DEG = 5.0
UNPLACED = "The places of the sensors are not known, so the mode shapes cannot be drawn; the model below lists them."
MOVING = "Motion of the beam at its natural frequencies, slowed down and magnified. The dots are the sensors."
DRAWN = "Mode shapes over the length of the beam with bars of one sigma, one panel a mode, the clamp at the left"
CAPTION = (
    "Mode shapes at unit modal mass with bars of one standard deviation; a bar may be smaller than its mark. "
    "The free end, or where the beam moves most, points up. The curve between the points is interpolated."
)


def shapes_section(content: ReportContent) -> Section:
    """Animated shapes of the first test that has them; below, all shapes with sigma bars."""
    anchor, heading = "shapes", "The mode shapes"
    spatial = _spatial_shapes(content)
    if spatial is not None:
        return Section(anchor, heading, spatial)
    absent = tuple(
        f"{_name_of_test(m.test)} has no mode shapes at unit modal mass ({m.shapes_unavailable})."
        for m in content.models
        if m.shapes is None and m.n_modes
    )
    figure = mode_shapes(content.models, content.rig)
    drawn = next((m for m in content.models if m.n_modes and beam_shape(m, 0, content.rig) is not None), None)
    if figure is None or drawn is None:
        unplaced = any(m.shapes is not None and m.n_modes for m in content.models)
        return Section(anchor, heading, None, (*absent, UNPLACED) if unplaced else absent)
    still = captioned_figure(figure, "shapes", DRAWN, CAPTION, min(3, drawn.n_modes))
    moving = animated_shapes(drawn, content.rig)
    parts = [paragraph(MOVING), moving, _skew_note(content), still, comparison_tables(content)]
    return Section(anchor, heading, join_markup(parts), absent)


def _spatial_shapes(content: ReportContent) -> Markup | None:
    """Moving shapes in space, of a structure that is more than a beam, or of responses alone."""
    rig = content.rig
    for model in content.models:
        moving = shapes_of_model(model, rig)
        if not moving or not (is_spatial(rig) or (model.shapes is None and model.operating_shapes is not None)):
            continue
        points = {p.id: (p.x_m, p.y_m, p.z_m) for p in rig.points}
        # Points on one axis are drawn as a beam; what joins others in space is not known.
        along = [] if is_spatial(rig) else [p.id for p in sorted(rig.points, key=lambda p: p.x_m)]
        drawn = moving_wireframes(points, rig.lines or tuple(pairwise(along)), moving, rig.surfaces)
        if drawn is not None:
            scale = "" if model.shapes is not None else " Without a force the shapes have no scale."
            text = f"Motion of the structure at its natural frequencies, slowed down and magnified.{scale}"
            return join_markup([paragraph(text), drawn])
    return None


def _skew_note(content: ReportContent) -> str | None:
    for model in content.models:
        found = [beam_shape(model, i, content.rig) for i in range(model.n_modes)]
        loose = [
            f"mode {i + 1} by {s.skew_deg:.0f}°" for i, s in enumerate(found) if s and s.skew_deg > OUT_OF_STEP_DEG
        ]
        if loose:
            return paragraph(
                f"In the {model.test or 'FRF'} test the points do not move exactly in phase: {', '.join(loose)}. "
                "Light, evenly spread damping gives motion in phase. The animation shows all motion, the figure "
                "below the part in phase."
            )
    return None


def _name_of_test(test: str | None) -> str:
    return f"The {test} test" if test else "The FRFs"


COMPARED = (
    "MAC is 1 if two shapes are equal up to a factor. CoMAC compares one point over all modes: a point far "
    "below the others has a sensor that is loose, turned or swapped in one of the tests."
)


def comparison_tables(content: ReportContent) -> Markup | None:
    """Tables for every two tests that share modes and points."""
    there = [(o, o.model) for o in content.outcomes if o.model is not None and o.model.n_modes]
    parts: list[Markup] = []
    for (one, first), (other, second) in combinations(there, 2):
        try:
            parts += _shape_tables(
                f"{_named_outcome(one)} and {_named_outcome(other)}", first, compare_shapes(first, second)
            )
        except DataError:
            # One test of one sensor, or bands apart: there is nothing to compare.
            continue
    return join_markup([*parts, paragraph(COMPARED)]) if parts else None


def _shape_tables(names: str, first: ModalModel, found: ShapeComparison) -> list[Markup]:
    modes = [
        (f"{first.frequency_hz[i]:.4g} Hz", four_places(float(value)))
        for (i, _), value in zip(found.pairs, found.mac, strict=True)
    ]
    points = [(f"Point {p}", four_places(float(value))) for p, value in zip(found.points, found.comac, strict=True)]
    by_point = html_table(f"CoMAC of {names} over {len(found.pairs)} modes", ("point", "CoMAC"), points, (1,))
    return [
        html_table(f"Do the shapes of {names} agree?", ("mode", "MAC"), modes, (1,)),
        html_element("details", html_element("summary", f"CoMAC at every point, {names}"), by_point),
    ]


def _named_outcome(outcome: OutcomeOfTest) -> str:
    return f"the {outcome.test} test" if outcome.test else "the FRFs"
