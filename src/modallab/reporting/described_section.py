"""The part of a diagnosis's report that says what a gap without a name behaves like."""

from modallab.core.described import Learned
from modallab.core.diagnosis import Diagnosis
from modallab.core.rounded import rounded
from modallab.reporting.gap_candidates import closed_bar
from modallab.reporting.gap_page import captioned, section
from modallab.reporting.markup import Markup, table, tag
from modallab.twin.effects import model_of


def _between(element: Learned, name: str) -> str:
    """The interval of a number; why there is none, where it is not known."""
    within, why = element.interval.get(name), element.not_known.get(name)
    if within is not None:
        return f"{within[0]:.5g} to {within[1]:.5g}"
    return f"not known: {why}" if why else ""


def described_section(diagnosis: Diagnosis) -> Markup | None:
    """What the gap behaves like, its numbers and how far it closes it; None where nothing describes it."""
    described = diagnosis.described
    if described is None:
        return None
    rows: list[list[str]] = []
    for element in described.elements:
        kind = model_of(element.element).kind
        for name, value in element.parameters.items():
            unit = kind.parameter(name).unit
            between = _between(element, name)
            rows.append([f"{name} {f'({unit})' if unit else ''}".strip(), f"{value:.5g}", between])
    if described.x_m is not None:
        between = "{:.4f} to {:.4f}".format(*described.x_m_interval) if described.x_m_interval is not None else ""
        rows.append(["place (m from the clamp)", f"{described.x_m:.4f}", between])
    shrink = described.shrink
    said = (
        f"Share of the reducible gap that this closes on {len(shrink.held_out)} records no fit has seen: from "
        f"{rounded(shrink.before)} to {rounded(shrink.after)} noise units. It is no cause: another thing may behave "
        "alike."
    )
    others = [tag("li", f"{other.says}: leaves {rounded(other.gap)} noise units") for other in described.alternatives]
    return section(
        "What it behaves like",
        tag("p", f"The gap behaves like {described.says.rstrip(',')}."),
        table("A learned element of the simulation", ["number", "value", "95 % interval"], rows, numeric=(1,)),
        captioned(closed_bar("with the learned element", shrink), said),
        tag("p", model_of(described.elements[0].element).experiment),
        tag("ul", *others) if others else None,
    )
