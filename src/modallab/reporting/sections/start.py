"""How the modes were found: the stabilisation diagram, the mode indicators, and what was picked."""

from modallab.core.digits import count_with_noun
from modallab.core.model import ModalModel
from modallab.identification.estimator import USUAL, ModelOrder, estimator_of, find_estimator
from modallab.identification.selection.diagram import StabilisationData
from modallab.reporting.content import OutcomeOfTest, ReportContent
from modallab.reporting.figures.stabilisation import stabilisation_panels
from modallab.reporting.markup import Markup, html_element, join_markup
from modallab.reporting.sections.section import Section, captioned_figure, paragraph

HEADING = "How the modes were found"
LEAD = (
    "A model of too low an order misses modes, one of too high an order adds poles that fit noise. The order is "
    "therefore increased step by step: stable poles belong to the structure. CMIF has a peak at each mode, and two "
    "curves of CMIF have a peak where two modes share a frequency. MIF has a minimum at each mode."
)


def stabilisation_section(content: ReportContent) -> Section:
    """One diagram a test."""
    parts: list[Markup] = []
    absent: list[str] = []
    for i, outcome in enumerate(content.outcomes):
        if outcome.model is None:
            continue
        if isinstance(outcome.diagram, str):
            absent.append(f"There is no stabilisation diagram of {_name_of_test(outcome)}: {outcome.diagram}.")
        elif outcome.diagram is not None:
            parts += _diagram_of_test(outcome, outcome.model, outcome.diagram, i)
    body = join_markup([paragraph(LEAD), *parts]) if parts else None
    return Section("start", HEADING, body, tuple(absent))


def _diagram_of_test(outcome: OutcomeOfTest, model: ModalModel, diagram: StabilisationData, place: int) -> list[Markup]:
    order = _order_sentence(model)
    name = "order" if order is None else order.meaning
    says = _picked_poles(model, diagram)
    figure = captioned_figure(
        stabilisation_panels(diagram, model.frequency_hz, name),
        f"start-{outcome.test or 'frf'}-{place}",
        f"Stabilisation diagram, CMIF and MIF of {_name_of_test(outcome)} over frequency. {says}",
        f"{says} The averaged FRFs are those of the estimator{_damped_note(outcome)}.",
    )
    called = _name_of_test(outcome)
    return [html_element("h3", called[0].upper() + called[1:]), figure]


def _picked_poles(model: ModalModel, diagram: StabilisationData) -> str:
    held = count_with_noun(int(diagram.held_hz.size), "pole")
    modes = count_with_noun(model.n_modes, "mode")
    if _order_sentence(model) is None:
        beside = find_estimator(USUAL).called
        return f"{held} hold over the orders of {beside}, which are drawn to compare; {modes} were read off the peaks."
    more = int(diagram.held_hz.size) - model.n_modes
    says = f"{held} hold over enough orders; {modes} stand in the model."
    if more > 0:
        return (
            f"{says} A stable pole that is no mode fits noise, represents a mode outside the band, or was left "
            "out by hand."
        )
    if more < 0:
        return f"{says} Other modes were found in the residual, were added by hand, or share a pole."
    return says


def _order_sentence(model: ModalModel) -> ModelOrder | None:
    known = estimator_of(model.method)
    return None if known is None else known.order


def _damped_note(outcome: OutcomeOfTest) -> str:
    if outcome.test != "impact":
        return ""
    return ", with artificial damping, so that every ring-down ends within the block: their peaks are broader"


def _name_of_test(outcome: OutcomeOfTest) -> str:
    return f"the {outcome.test} test" if outcome.test else "the FRFs"
