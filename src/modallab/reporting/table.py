"""The table of modes for the terminal."""

from collections.abc import Sequence
from math import isfinite

from rich import box
from rich.table import Table

from modallab.core.digits import UNKNOWN, number_with_sigma, probability_text, rounded_to_sigma, significant_digits
from modallab.core.model import ModalModel
from modallab.reporting.compare import ComparedMode, Confidence, ModeReading, matched_modes
from modallab.reporting.content import TrueModes

# No Greek letters: a terminal that knows only its country's letters would stop at them.
VALUES = ("frequency\n[Hz]", "damping\n[%]", "half-power\n[%]")
TRUTH = ("true\n[Hz]", "true\n[%]")
CONFIDENCE = "confi-\ndence"


def modal_table(
    models: Sequence[ModalModel], truth: TrueModes | None = None, confidence: Sequence[Confidence] = ()
) -> Table:
    """Frequency and damping of every mode with their sigma, the half-power reading, truth and confidence where known.

    Args:
        models: one a test.
        truth: the modes of a simulated bench.
        confidence: how clearly each mode stands, one array a model.

    Returns:
        a table to be printed by rich; it fits into 80 columns.
    """
    table = Table(
        title="Modal model", caption=_caption_of_table(models, truth), box=box.SIMPLE_HEAD, padding=0, show_edge=False
    )
    table.title_justify = table.caption_justify = "left"
    for heading in ("mode", "test"):
        table.add_column(heading, no_wrap=True, min_width=6 if heading == "test" else 4)
    found = matched_modes(models, truth, confidence)
    known = any(isfinite(reading.confidence) for mode in found for reading in mode.readings)
    for heading in (*VALUES, *(TRUTH if truth else ()), *((CONFIDENCE,) if known else ())):
        table.add_column(heading, justify="right", no_wrap=True, min_width=max(map(len, heading.split())))
    for mode in found:
        for reading in mode.readings:
            cells = _cells_of_mode(mode, reading, truth is not None)
            if known:
                cells.append(probability_text(reading.confidence))
            table.add_row(*cells, end_section=reading is mode.readings[-1])
    return table


def _cells_of_mode(mode: ComparedMode, reading: ModeReading, true: bool) -> list[str]:
    cells = [
        str(mode.number),
        reading.test or "FRFs",
        number_with_sigma(reading.frequency_hz, reading.frequency_sigma_hz),
        number_with_sigma(100 * reading.damping, 100 * reading.damping_sigma),
        significant_digits(100 * reading.half_power, 3) if isfinite(reading.half_power) else "-",
    ]
    if not true:
        return cells
    if not isfinite(reading.true_frequency_hz):
        return [*cells, UNKNOWN, UNKNOWN]
    return [
        *cells,
        rounded_to_sigma(reading.true_frequency_hz, reading.frequency_sigma_hz),
        rounded_to_sigma(100 * reading.true_damping, 100 * reading.damping_sigma),
    ]


def _caption_of_table(models: Sequence[ModalModel], truth: TrueModes | None) -> str:
    if not models:
        return "No test could be identified."
    if not any(m.n_modes for m in models):
        return "No mode was found in the band."
    by = 0.0 if truth is None else 100 * truth.drift
    drift = f" True values are those at the start; the bench's stiffness then drifts by {by:+.2g} %." if by else ""
    return (
        "4.80(3) stands for 4.80 ± 0.03, one standard deviation. "
        "If the beam still rings when a block ends, half-power reads the block's length, not the damping." + drift
    )
