"""The part of a diagnosis's report that says what a gap without a name behaves like."""

from modallab.core.described import Learned
from modallab.core.diagnosis import Diagnosis
from modallab.core.digits import rounded, with_interval
from modallab.reporting.gap_candidates import closed_bar
from modallab.reporting.gap_page import captioned_picture, section
from modallab.reporting.markup import Markup, table, tag
from modallab.twin.effects import model_of


def _number(element: Learned, name: str) -> tuple[str, str]:
    """A number and its interval; why there is none, where it is not known."""
    value, between = with_interval(element.parameters[name], element.interval.get(name))
    why = element.not_known.get(name)
    return value, f"not known: {why}" if why else between


def described_section(diagnosis: Diagnosis) -> Markup | None:
    """What the gap behaves like, its numbers and how far it closes it; None where nothing describes it."""
    described = diagnosis.described
    if described is None:
        return None
    rows: list[list[str]] = []
    for element in described.elements:
        kind = model_of(element.element).kind
        for name in element.parameters:
            unit = kind.parameter(name).unit
            rows.append([f"{name} {f'({unit})' if unit else ''}".strip(), *_number(element, name)])
    if described.x_m is not None:
        rows.append(["place (m from the clamp)", *with_interval(described.x_m, described.x_m_interval)])
    shrink = described.shrink
    caption = (
        f"Share of the reducible gap that this closes on {len(shrink.held_out)} records no fit has seen: from "
        f"{rounded(shrink.before)} to {rounded(shrink.after)} noise units. It is no cause: another thing may behave "
        "alike."
    )
    others = [tag("li", f"{other.says}: leaves {rounded(other.gap)} noise units") for other in described.alternatives]
    return section(
        "What it behaves like",
        tag("p", f"The gap behaves like {described.says.rstrip(',')}."),
        table("A learned element of the simulation", ["number", "value", "95 % interval"], rows, numeric=(1,)),
        captioned_picture(closed_bar("with the learned element", shrink), caption),
        tag("p", model_of(described.elements[0].element).experiment),
        tag("ul", *others) if others else None,
    )
