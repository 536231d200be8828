"""How the modes were found: the stabilisation diagram, the mode indicators, and what was picked."""

from modallab.core.digits import counted
from modallab.core.model import ModalModel
from modallab.identification.estimator import USUAL, Order, estimator_of, find_estimator
from modallab.identification.selection.diagram import Diagram
from modallab.reporting.content import Outcome, ReportContent
from modallab.reporting.figures.stabilisation import stabilisation
from modallab.reporting.markup import Markup, join, tag
from modallab.reporting.sections.section import Section, captioned_figure, paragraph

HEADING = "How the modes were found"
LEAD = (
    "A model of too low an order misses modes, one of too high an order adds poles that fit noise. So the order is "
    "raised step by step: poles that stay where they are belong to the structure. CMIF peaks where a mode is; two of "
    "its curves peak together where two modes share a frequency. MIF dips there."
)


def section(content: ReportContent) -> Section:
    """One diagram a test."""
    parts: list[Markup] = []
    absent: list[str] = []
    for i, outcome in enumerate(content.outcomes):
        if outcome.model is None:
            continue
        if isinstance(outcome.diagram, str):
            absent.append(f"There is no stabilisation diagram of {_called(outcome)}: {outcome.diagram}.")
        elif outcome.diagram is not None:
            parts += _one(outcome, outcome.model, outcome.diagram, i)
    body = join([paragraph(LEAD), *parts]) if parts else None
    return Section("start", HEADING, body, tuple(absent))


def _one(outcome: Outcome, model: ModalModel, diagram: Diagram, place: int) -> list[Markup]:
    order = _order(model)
    name = "order" if order is None else order.meaning
    says = _picked(model, diagram)
    figure = captioned_figure(
        stabilisation(diagram, model.frequency_hz, name),
        f"start-{outcome.test or 'frf'}-{place}",
        f"Stabilisation diagram, CMIF and MIF of {_called(outcome)} over frequency. {says}",
        f"{says} The averaged FRFs are drawn as the estimator saw them{_damped(outcome)}.",
    )
    called = _called(outcome)
    return [tag("h3", called[0].upper() + called[1:]), figure]


def _picked(model: ModalModel, diagram: Diagram) -> str:
    held = counted(int(diagram.held_hz.size), "pole")
    modes = counted(model.n_modes, "mode")
    if _order(model) is None:
        beside = find_estimator(USUAL).called
        return f"{held} hold over the orders of {beside}, which are drawn to compare; {modes} were read off the peaks."
    more = int(diagram.held_hz.size) - model.n_modes
    says = f"{held} hold over enough orders; {modes} stand in the model."
    if more > 0:
        return f"{says} What held and is no mode fitted noise, stood for one outside the band, or was left out by hand."
    if more < 0:
        return f"{says} The others were found in the residual of these, by hand, or share a pole."
    return says


def _order(model: ModalModel) -> Order | None:
    known = estimator_of(model.method)
    return None if known is None else known.order


def _damped(outcome: Outcome) -> str:
    if outcome.test != "impact":
        return ""
    return ", with the artificial damping that lets every ring-down end within the block: their peaks are broader"


def _called(outcome: Outcome) -> str:
    return f"the {outcome.test} test" if outcome.test else "the FRFs"
