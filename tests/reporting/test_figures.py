"""Each figure shows the numbers it was given, with a unit on every axis."""

import warnings
from dataclasses import replace
from itertools import pairwise
from math import nan

import figure_data
import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

from modallab.reporting.compare import matched_modes
from modallab.reporting.content import TrueModes
from modallab.reporting.figures.blocks import cut_pulse, hits_figure, impact_block, sine_block
from modallab.reporting.figures.damping import damping_figure, half_power_reading, half_power_readings, paper_value
from modallab.reporting.figures.mobility import frf_at_one_point, frf_overview, mobility_panels
from modallab.reporting.figures.mode_shapes import example_block, farthest_sensor, mode_shapes

BOTH = ("impact", "sine")


@pytest.fixture(scope="module")
def found(content):
    return matched_modes(content.models, content.truth)


@pytest.fixture(scope="module")
def figures(content, found):
    impact, sine = content.outcomes
    rig = content.rig
    return {
        "sine": sine_block(sine.example, 9, rig),
        "impact": impact_block(impact.example, 9, rig, impact.filtered),
        "shapes": mode_shapes(content.models, rig),
        "all": mobility_panels(impact.verification),
        "all sine": mobility_panels(sine.verification),
        "one": frf_at_one_point(impact.verification, 9),
        "overview": frf_overview(impact.frf, 0, impact.model.frequency_hz),
        "hits": hits_figure(impact.hits, (3.0, 110.0)),
        "damping": damping_figure(found),
        "resolution": half_power_reading(found[0], found[0].readings[0], 1.024, 0.05),
    }


def test_every_axis_has_a_label_with_a_unit(figures):
    for name, figure in figures.items():
        for axes in figure.axes:
            assert axes.get_title(loc="left"), name
            assert "[" in axes.get_xlabel(), name
            # The rows of the damping figure are modes, which have no unit.
            assert "[" in axes.get_ylabel() or name == "damping", name


def test_no_text_leaves_its_cell_and_no_labels_overlap(figures):
    for name, figure in figures.items():
        figure.canvas.draw()
        for axes in figure.axes:
            labels = [t.get_window_extent() for t in axes.get_xticklabels() if t.get_text()]
            low, high = axes.get_window_extent().intervalx
            seen = sorted((b.x0, b.x1) for b in labels if low <= (b.x0 + b.x1) / 2 <= high)
            assert all(a[1] < b[0] for a, b in pairwise(seen)), name
            assert axes.yaxis.label.get_window_extent().x0 >= axes.get_window_extent().x0 - 62, name


def test_drawing_leaves_matplotlibs_own_settings_alone(figures):
    assert figures
    assert mpl.rcParams["svg.fonttype"] == mpl.rcParamsDefault["svg.fonttype"]
    assert mpl.rcParams["font.size"] == mpl.rcParamsDefault["font.size"]


@pytest.mark.parametrize("test", BOTH)
def test_a_block_is_drawn_as_it_was_measured(content, figures, test):
    signals = next(o.example for o in content.outcomes if o.test == test)
    force, force_spectrum, response, spectrum = figures[test].axes
    np.testing.assert_array_equal(force.lines[0].get_ydata(), signals.force)
    np.testing.assert_array_equal(response.lines[0].get_ydata(), signals.responses[9])
    np.testing.assert_allclose(response.lines[0].get_xdata(), np.arange(signals.force.size) / signals.rate_hz)
    assert force.get_ylabel() == "force [N]"
    assert response.get_ylabel() == "acceleration [m/s²]"
    assert {a.get_xlabel() for a in (force_spectrum, spectrum)} == {"frequency [Hz]"}


def test_the_amplitude_spectrum_shows_the_amplitude_of_the_sine(figures):
    spectrum = figures["sine"].axes[1].lines[0]
    peak = np.argmax(spectrum.get_ydata())
    assert spectrum.get_xdata()[peak] == pytest.approx(27.34, abs=0.01)
    assert spectrum.get_ydata()[peak] == pytest.approx(1.2, rel=0.01)


def test_the_filtered_response_is_dashed_in_the_fourth_panel_only(figures):
    dashed = [[line.get_linestyle() for line in axes.lines] for axes in figures["impact"].axes]
    assert dashed == [["-"], ["-"], ["-"], ["-", "--"]]


def test_the_sine_block_nearest_to_the_papers_frequency_is_shown(content):
    assert example_block(content.campaign, "sine").frequency_hz == pytest.approx(28 / 1.024)
    assert example_block(content.campaign, "impact").name == "impact_001"
    assert example_block(replace(content.campaign, blocks=()), "sine") is None


def test_the_farthest_sensor_is_the_free_end(content):
    assert farthest_sensor(content.rig, ("a03", "a10", "a09")) == 1
    assert farthest_sensor(content.rig, ("x", "y")) == 1


def test_mobility_is_compared_at_every_point_with_its_frac(content, figures):
    check = content.outcomes[0].verification
    figure = figures["all"]
    assert len(figure.axes) == 10
    for i, axes in enumerate(figure.axes):
        untruncated, measured, regenerated, residual = axes.lines
        np.testing.assert_allclose(measured.get_ydata(), np.abs(check.measured.values[i, 0]))
        np.testing.assert_allclose(regenerated.get_ydata(), np.abs(check.regenerated.values[i, 0]))
        np.testing.assert_allclose(untruncated.get_ydata(), np.abs(check.untruncated.values[i, 0]))
        left = np.abs(check.measured.values[i, 0] - check.regenerated.values[i, 0])
        np.testing.assert_allclose(residual.get_ydata(), left)
        np.testing.assert_array_equal(untruncated.get_xdata(), check.untruncated.frequency_hz)
        assert axes.get_title(loc="left") == f"Point {i + 1} · FRAC {check.frac[i, 0]:.4f}"
        assert axes.get_yscale() == "log"
        assert axes.get_ylabel() == "mobility [m/(N·s)]"
        assert untruncated.get_linewidth() < regenerated.get_linewidth()
    assert len({axes.get_ylim() for axes in figure.axes}) == 1


def test_single_frequencies_are_not_joined_by_lines(figures):
    untruncated, measured, regenerated, _ = figures["all sine"].axes[0].lines
    assert untruncated.get_linestyle() == "-"
    assert measured.get_linestyle() == regenerated.get_linestyle() == "None"


def test_one_point_is_shown_in_amplitude_phase_real_and_imaginary_part(content, figures):
    value = content.outcomes[0].verification.measured.values[9, 0]
    for axes, part in zip(
        figures["one"].axes, (np.abs(value), np.angle(value, deg=True), value.real, value.imag), strict=True
    ):
        np.testing.assert_allclose(axes.lines[1].get_ydata(), part)
    real = figures["one"].axes[2]
    assert real.get_ylim()[1] < 2 * value.real.max(), "the model's own peak must not flatten what was measured"


def test_the_overview_shows_every_frf_and_its_coherence(content, figures):
    frf = content.outcomes[0].frf
    amplitude, coherence = figures["overview"].axes
    for i in range(10):
        np.testing.assert_allclose(amplitude.lines[i].get_ydata(), np.abs(frf.values[i, 0]))
        np.testing.assert_allclose(coherence.lines[i].get_ydata(), frf.coherence[i, 0])
    assert len(frf_overview(replace(frf, coherence=None)).axes) == 1


def test_shapes_have_one_sign_and_their_sigmas(content, figures):
    for mode, axes in enumerate(figures["shapes"].axes):
        bars = axes.containers
        assert len(bars) == 2
        for bar, model in zip(bars, content.models, strict=True):
            phi = bar.lines[0].get_ydata()
            np.testing.assert_allclose(phi, model.shapes[mode].real, atol=1e-12)
            assert phi[-1] > 0
            segments = np.array(bar.lines[2][0].get_segments())
            np.testing.assert_allclose(np.ptp(segments[:, :, 1], axis=1), 2 * model.shape_sigma[mode])
        assert axes.patches, "the clamp"


def test_a_sign_or_phase_of_the_estimator_changes_nothing_in_the_picture(content):
    turned = content.models[0].model_copy(update={"shapes": content.models[0].shapes * np.exp(0.7j)})
    figure = mode_shapes([turned], content.rig)
    for mode, axes in enumerate(figure.axes):
        drawn = axes.containers[0].lines[0].get_ydata()
        np.testing.assert_allclose(drawn, content.models[0].shapes[mode].real, atol=1e-6)


def test_no_shapes_or_no_places_give_no_picture(content):
    unknown = figure_data.rig(
        model="unknown", beam=None, points=(), shaker_point=None, channels=_unplaced(content.rig.channels)
    )
    assert mode_shapes([content.models[0].model_copy(update={"shapes": None})], content.rig) is None
    assert mode_shapes(content.models, unknown) is None
    assert mode_shapes([], content.rig) is None


def _unplaced(channels):
    return [c.model_copy(update={"point": None}) for c in channels]


def test_rejected_hits_are_dashed_and_every_hit_is_there(content, figures):
    hits = content.outcomes[0].hits
    lines = figures["hits"].axes[0].lines
    for line, hit in zip(lines, hits, strict=True):
        assert line.get_linestyle() == ("-" if hit.accepted else "--")
        time, force = cut_pulse(hit)
        np.testing.assert_array_equal(line.get_ydata(), force)
        assert time[np.argmax(force)] == 0
        assert force.max() == hit.force_n.max()


def test_the_damping_figure_sets_readings_at_the_floor_and_the_identified_value_inside(found, figures):
    axes = figures["damping"].axes[0]
    diamonds = [line for line in axes.lines if line.get_marker() == "D"]
    assert [float(d.get_xdata()[0]) for d in diamonds] == pytest.approx(
        [100 * r.half_power for m in found for r in m.readings]
    )
    identified = [float(c.lines[0].get_xdata()[0]) for c in axes.containers if hasattr(c, "lines")]
    assert identified == pytest.approx([100 * r.damping for m in found for r in m.readings])
    bars = [patch.get_width() for patch in axes.patches]
    assert bars == pytest.approx([100 * r.half_power_floor for m in found for r in m.readings])
    assert identified[0] < bars[0] / 10 < diamonds[0].get_xdata()[0]


def test_only_the_papers_modes_have_the_papers_values(found):
    assert [paper_value(m) for m in found] == [0.125, 0.0385, 0.0103]
    assert paper_value(replace(found[0], readings=(replace(found[0].readings[0], frequency_hz=6.0),))) is None


def test_half_power_reads_the_block_whatever_the_damping():
    light = np.array([1e-4, 1e-3, 5e-3, 1e-2])
    plain, hann = (half_power_readings(4.8, light, 1.024, 0.05, window) for window in (False, True))
    assert (plain > 0.06).all()
    assert (plain < 0.07).all()
    assert (hann > 0.118).all()
    assert (hann < 0.15).all()


def test_half_power_reads_the_beam_once_the_block_is_long():
    zeta = np.array([0.01, 0.02, 0.05])
    np.testing.assert_allclose(half_power_readings(4.8, zeta, 60.0, 0.05, hann=False), zeta, rtol=0.02)


def test_unknown_sigmas_and_readings_are_drawn_without_them():
    model = figure_data.model(
        damping_sigma=[nan] * 3, half_power=[nan] * 3, half_power_floor=[nan] * 3, frequency_sigma_hz=[nan] * 3
    )
    figure = damping_figure(matched_modes([model], TrueModes(figure_data.FREQUENCY, figure_data.DAMPING)))
    assert isinstance(figure, Figure)
    assert not figure.axes[0].patches


def test_the_same_figure_twice_is_the_same_file(content):
    from modallab.reporting.figures.svg import svg_panels

    made = [svg_panels(mobility_panels(content.outcomes[0].verification), "a", "alt", 3) for _ in range(2)]
    assert made[0] == made[1]


def test_no_warning_even_for_zeros(content):
    check = content.outcomes[0].verification
    dead = check.measured.values.copy()
    dead[3] = 0
    frac = check.frac.copy()
    frac[3] = nan
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure = mobility_panels(replace(check, measured=replace(check.measured, values=dead), frac=frac))
        figure.canvas.draw()
    assert figure.axes[3].get_title(loc="left") == "Point 4 · FRAC unknown"
