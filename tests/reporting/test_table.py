import io
from math import nan

import figure_data
import numpy as np
from rich.console import Console

from modallab.reporting.content import TrueModes
from modallab.reporting.table import modal_table


def printed(*arguments, encoding: str = "utf-8") -> str:
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding=encoding, newline="")
    Console(file=stream, width=80).print(modal_table(*arguments))
    stream.flush()
    return raw.getvalue().decode(encoding)


def test_the_table_says_what_the_models_say_and_fits_into_80_columns():
    models = [figure_data.model(), figure_data.model("sine", 4, 4)]
    text = printed(models, TrueModes(figure_data.FREQUENCY, figure_data.DAMPING))
    assert all(len(line) <= 80 for line in text.splitlines())
    assert "…" not in text
    rows = [line.split() for line in text.splitlines() if line.split() and line.split()[0].isdigit()]
    assert [r[:2] for r in rows] == [[str(i), t] for i in (1, 2, 3) for t in ("impact", "sine")]
    assert rows[0][2:] == ["4.8028(2)", "0.514(6)", "6.73", "4.8030", "0.510"]


def test_without_truth_there_are_no_columns_for_it():
    assert "true" not in printed([figure_data.model()])


def test_a_western_windows_terminal_can_print_it():
    assert "4.8028(2)" in printed([figure_data.model()], encoding="cp1252")


def test_unknown_numbers_and_no_modes_are_said():
    text = printed([figure_data.model(half_power=[nan] * 3, damping_sigma=[nan] * 3)])
    assert "0.5136(?)" in text
    assert "No test could be identified." in printed([])


def test_seven_sharp_modes_fit_into_80_columns():
    n = 7
    sharp = figure_data.model(
        frequency_hz=np.linspace(4.764744, 612.768053, n),
        damping_ratio=np.full(n, 0.00300074712),
        frequency_sigma_hz=np.full(n, 3.2e-6),
        damping_sigma=np.full(n, 1.1e-8),
        modal_constants=np.ones((n, 10, 1)),
        modal_constant_sigma=np.ones((n, 10, 1)),
        shapes=None,
        half_power=np.full(n, 0.06943),
        half_power_floor=np.full(n, 0.06),
    )
    text = printed([sharp], TrueModes(sharp.frequency_hz, sharp.damping_ratio), [np.full(n, 0.98)])
    assert "612.768053(3)" in text
    assert "…" not in text


def test_confidence_has_its_column_where_it_is_known_and_is_not_rounded_up_to_certainty():
    models = [figure_data.model(), figure_data.model("sine", 4, 4)]
    text = printed(models, TrueModes(figure_data.FREQUENCY, figure_data.DAMPING), [np.array([0.999, 0.5, 0.0]), None])
    assert all(len(line) <= 80 for line in text.splitlines())
    rows = [line.split() for line in text.splitlines() if line.split() and line.split()[0].isdigit()]
    assert [r[-1] for r in rows] == ["0.99", "-", "0.50", "-", "0.00", "-"]
    assert "confi-" not in printed(models)
