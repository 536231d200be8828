"""The set-ups of one test side by side: what each read of every mode, and which of them is off."""

from math import isfinite

from modallab.core.digits import list_in_words, relative_difference, with_sigma
from modallab.core.model import ModalModel
from modallab.identification.setups.readings import SetUpReading
from modallab.reporting.content import ReportContent
from modallab.reporting.markup import Markup, html_element, html_table, join_markup
from modallab.reporting.sections.section import Section, paragraph

ANCHOR, HEADING = "set-ups", "The set-ups"
HEADER = ("mode", "set-up", "frequency [Hz]", "difference", "damping ζ [%]", "difference")
EXPLAINED = (
    "Each set-up was identified by itself. The difference is that from the joined value: in percent of it, and in "
    "brackets in standard deviations (σ) of the set-up's own value. Off: the frequency, or the amplitude that the "
    "reference sensor reads, differs by more than 4 σ from the set-up that the others are compared with."
)


def setups_section(content: ReportContent) -> Section:
    """Frequencies and damping ratios by mode and set-up; nothing where there is one set-up only."""
    if not content.setups or not content.models:
        return Section(ANCHOR, HEADING, None)
    model = content.models[0]
    rows = [row for r in range(model.n_modes) for row in _rows_of_mode(r, model, content.setups)]
    caption = f"Frequency and damping of every mode in {len(content.setups)} set-ups"
    parts = [
        paragraph(_verdict_sentence(content.setups)),
        html_table(caption, HEADER, rows, range(2, 6), "wide"),
        paragraph(EXPLAINED),
    ]
    return Section(ANCHOR, HEADING, join_markup(parts))


def _rows_of_mode(r: int, model: ModalModel, setups: tuple[SetUpReading, ...]) -> list[list[str]]:
    hz, zeta = float(model.frequency_hz[r]), float(model.damping_ratio[r])
    joined = [
        str(r + 1),
        html_element("b", "joined"),
        with_sigma(hz, float(model.frequency_sigma_hz[r])),
        "",
        with_sigma(100 * zeta, 100 * float(model.damping_sigma[r])),
        "",
    ]
    return [joined, *(_row_of_setup(r, one, hz, zeta) for one in setups)]


def _row_of_setup(r: int, one: SetUpReading, hz: float, zeta: float) -> list[str]:
    f, sigma = float(one.frequency_hz[r]), float(one.frequency_sigma_hz[r])
    z, z_sigma = float(one.damping_ratio[r]), float(one.damping_sigma[r])
    return [
        "",
        join_markup([one.name, " ", html_element("strong", "off")]) if one.off[r] else one.name,
        with_sigma(f, sigma),
        _deviation_text(f, sigma, hz),
        with_sigma(100 * z, 100 * z_sigma),
        _deviation_text(z, z_sigma, zeta),
    ]


def _deviation_text(value: float, sigma: float, joined: float) -> Markup | str:
    if not (isfinite(sigma) and sigma > 0):
        return relative_difference(value, joined)
    away = (value - joined) / sigma
    sigmas = f"({away:+.{0 if abs(away) >= 10 else 1}f} σ)".replace("-", "−")
    return join_markup([relative_difference(value, joined), " ", html_element("small", sigmas)])


def _verdict_sentence(setups: tuple[SetUpReading, ...]) -> str:
    off = [one for one in setups if one.off.any()]
    if not off:
        return "The set-ups agree: no frequency and no amplitude at the reference differs by more than chance."
    if len(setups) == 2:
        return (
            f"The set-ups {setups[0].name} and {setups[1].name} differ by more than chance. Two set-ups do not "
            "show which one is off: repeat one of them."
        )
    named = list_in_words(
        [f"{one.name} (modes {list_in_words([str(r + 1) for r in one.off.nonzero()[0]])})" for one in off]
    )
    return (
        f"Off: set-up {named}, compared with {off[0].against}. Check mass, cable and mounting of its sensors, "
        "the clamp, and the temperature."
    )
