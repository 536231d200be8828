"""The part of a diagnosis's report that says what a gap without a name behaves like."""

from modallab.core.diagnosis import Diagnosis
from modallab.reporting.gap_candidates import closed_bar
from modallab.reporting.gap_page import captioned, section
from modallab.reporting.markup import Markup, table, tag
from modallab.twin.effects import model_of


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
            interval = element.interval.get(name)
            between = f"{interval[0]:.5g} to {interval[1]:.5g}" if interval is not None else ""
            rows.append([f"{name} {f'({unit})' if unit else ''}".strip(), f"{value:.5g}", between])
    if described.x_m is not None:
        between = "{:.4f} to {:.4f}".format(*described.x_m_interval) if described.x_m_interval is not None else ""
        rows.append(["place (m from the clamp)", f"{described.x_m:.4f}", between])
    shrink = described.shrink
    said = (
        f"Share of the reducible gap that this closes on {len(shrink.held_out)} records no fit has seen: from "
        f"{shrink.before:.3g} to {shrink.after:.3g} noise units. It is no cause: another thing may behave alike."
    )
    others = [tag("li", f"{other.says}: leaves {other.gap:.3g} noise units") for other in described.alternatives]
    return section(
        "What it behaves like",
        tag("p", f"The gap behaves like {described.says.rstrip(',')}."),
        table("A learned element of the simulation", ["number", "value", "95 % interval"], rows, numeric=(1,)),
        captioned(closed_bar("with the learned element", shrink), said),
        tag("p", model_of(described.elements[0].element).experiment),
        tag("ul", *others) if others else None,
    )
