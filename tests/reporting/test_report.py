"""The report as a reader's browser gets it."""

import re
import time
from dataclasses import replace
from math import nan

import figure_data
import numpy as np
import pytest
from page_reader import Page

from modallab.core.digits import relative_difference, rounded_to_sigma, with_sigma
from modallab.core.errors import StorageError
from modallab.reporting.content import OutcomeOfTest, ReportContent, ReportedHit
from modallab.reporting.figures.style import panel_grid
from modallab.reporting.figures.svg import svg_panels
from modallab.reporting.report import render, write_report

EVIL = "</title><script>alert(1)</script>\"'&$x^2$"


@pytest.fixture(scope="module")
def slim(content) -> ReportContent:
    """The same with fewer figures, so that drawing it takes no time."""
    return replace(content, outcomes=tuple(replace(o, verification=None, frf=None, hits=()) for o in content.outcomes))


@pytest.fixture(scope="module")
def parsed(page) -> Page:
    return Page(page)


def test_the_page_loads_nothing_from_anywhere(page, parsed):
    assert not re.findall(r"https?://|//[a-z]+\.[a-z]", page)
    assert not {tag for tag, _ in parsed.tags} & {"link", "iframe", "object", "embed", "img"}
    loaded = [a[k] for _, a in parsed.tags for k in ("src", "href", "data", "action") if k in a]
    assert all(value.startswith("#") for value in loaded)
    assert "url(http" not in page
    assert "@import" not in page


def test_every_link_inside_the_page_has_its_target_once(parsed):
    ids = [a["id"] for _, a in parsed.tags if "id" in a]
    assert len(ids) == len(set(ids))
    linked = {a["href"][1:] for _, a in parsed.tags if a.get("href", "").startswith("#")}
    assert linked <= set(ids)
    used = set(re.findall(r"url\(#([^)]+)\)", str(parsed.tags)))
    assert used <= set(ids)


def test_every_figure_has_words_for_those_who_cannot_see_it(parsed):
    plates = [a for a in parsed.all("figure") if a.get("class") == "plate"]
    pictures = [a for a in parsed.all("div") if a.get("role") == "img"]
    assert len(plates) == len(pictures) == 11
    assert all(len(p["aria-label"]) > 30 for p in pictures)
    free = [a for a in parsed.all("svg") if a.get("aria-hidden") != "true"]
    assert len(free) == len(parsed.all("title")) - 1 == 3, "each moving shape has a title, as has the page"
    assert parsed.all("html")[0]["lang"] == "en"


def test_every_table_has_headers_and_full_rows(parsed):
    assert len(parsed.tables) >= 8
    for table in parsed.tables:
        assert table.caption
        assert len({len(row) for row in table.rows}) == 1
        assert table.scopes.count("col") == len(table.rows[0])
        assert table.scopes.count("row") == len(table.rows) - 1


def test_the_table_holds_the_numbers_of_the_models(content, parsed):
    rows = parsed.table("Natural frequencies").rows[1:]
    assert [(r[0], r[1]) for r in rows] == [(str(i), t) for i in (1, 2, 3) for t in ("impact", "sine")]
    for i, row in enumerate(rows):
        model, mode = content.models[i % 2], i // 2
        assert row[2] == with_sigma(model.frequency_hz[mode], model.frequency_sigma_hz[mode])
        assert row[3] == with_sigma(100 * model.damping_ratio[mode], 100 * model.damping_sigma[mode])
        assert float(row[4]) == pytest.approx(100 * model.half_power[mode], rel=5e-3)
        assert row[5].startswith(rounded_to_sigma(figure_data.FREQUENCY[mode], model.frequency_sigma_hz[mode]))
        assert row[6].startswith(rounded_to_sigma(100 * figure_data.DAMPING[mode], 100 * model.damping_sigma[mode]))
        assert relative_difference(model.damping_ratio[mode], figure_data.DAMPING[mode]) in row[6]


def test_the_summary_is_one_sentence_with_the_modes_and_the_verdict(parsed):
    lead = parsed.text[parsed.text.index("3 modes between") :].split(".\n")[0]
    assert lead.startswith("3 modes between 3 and 110 Hz: 4.803 Hz with a damping ratio of 0.51 %, ")
    assert "the impact test and the sine test agree within their uncertainty." in parsed.text


def test_tests_that_disagree_are_said_to(slim):
    impact, sine = slim.outcomes
    off = sine.model.model_copy(update={"damping_ratio": sine.model.damping_ratio * 1.3})
    text = Page(render(replace(slim, outcomes=(impact, replace(sine, model=off))))).text
    assert "the impact test and the sine test disagree, frequencies by up to 0" in text
    assert re.search(r"damping ratios by up to 3\d %", text)
    assert "In the sine test the shaker is attached to the structure" in text
    assert "agree within their uncertainty" not in text


@pytest.mark.thorough("renders a whole report once more")
def test_a_model_that_misses_its_measurement_is_said_to_at_the_top(content, slim):
    impact = slim.outcomes[0]
    check = content.outcomes[0].verification
    poor = replace(check, frac=np.where(np.arange(10)[:, None] == 4, 0.31, check.frac))
    lead = Page(render(replace(slim, outcomes=(replace(impact, verification=poor),)))).text
    assert "at some points the model does not reproduce the impact test (FRAC down to 0.3100)." in lead


def test_a_mode_that_a_test_missed_in_its_band_is_named(slim):
    impact, sine = slim.outcomes
    lost = {"band_hz": (20.0, 110.0)} | {
        name: getattr(sine.model, name)[2:]
        for name in (
            "frequency_hz",
            "damping_ratio",
            "frequency_sigma_hz",
            "damping_sigma",
            "modal_constants",
            "modal_constant_sigma",
            "shapes",
            "shape_sigma",
            "half_power",
            "half_power_floor",
        )
    }
    text = Page(render(replace(slim, outcomes=(impact, replace(sine, model=sine.model.model_copy(update=lost)))))).text
    assert "The sine test did not find mode 2, although they are in its band." in text


def test_a_sigma_that_the_truth_refutes_is_named(slim, parsed):
    assert "uncertainty is too small" not in parsed.text
    sure = figure_data.model(frequency_sigma_hz=[2e-4, 1e-3, 1e-9])
    text = Page(render(replace(slim, outcomes=(replace(slim.outcomes[0], model=sure),)))).text
    assert "More than 3 σ off the truth: mode 3 (impact)." in text


def test_the_half_power_reading_is_called_the_resolution_of_the_block(parsed):
    text = parsed.sections["half-power"]
    assert "A mode with no damping at all would give 6.7 %" in text
    assert "ζ = 6.25 %" in text
    assert "Hann window" in text
    assert "is the resolution of the block and says nothing about the beam" in text


@pytest.mark.thorough("renders a whole report once more")
def test_the_papers_values_stand_on_the_papers_bench_only(slim):
    beam = slim.rig.beam.model_copy(update={"thickness_m": 0.006})
    other = slim.rig.model_copy(update={"beam": beam})
    text = render(replace(slim, campaign=replace(slim.campaign, rig=other)))
    assert "paper" in render(slim)
    assert "paper" not in re.sub(r"<style>.*?</style>|--paper", "", text)


def test_the_model_is_there_in_full(content, parsed):
    constants = parsed.table("Modal constants").rows
    assert len(constants) == 11
    value = content.models[0].modal_constants[0, 9, 0].real
    assert float(constants[10][1].split(" ± ")[0]) == pytest.approx(value, rel=5e-3)


def test_frac_of_every_point_is_listed(content, parsed):
    rows = parsed.table("FRAC of measured").rows[1:]
    assert [r[0] for r in rows] == [f"Point {i}" for i in range(1, 11)]
    assert [float(r[1]) for r in rows] == pytest.approx(content.outcomes[0].verification.frac[:, 0], abs=1e-4)


def test_channels_carry_serial_and_calibration_and_blocks_their_rates(parsed):
    rows = parsed.table("Channels").rows
    assert ["a10", "acceleration [m/s²]", "10", "+z", "0.01 (impact) and 0.1 (sine)", "A-710", "2024-03-07"] in rows
    facts = dict(parsed.table("Provenance").rows)
    assert facts["rates, impact test"] == "requested 2000 Hz, actual 2000 Hz, delivered 2000 Hz"
    assert facts["seed"] == "1"
    assert facts["the truth is known from"] == "the simulated bench, seed 1"


def test_rejected_hits_stand_with_their_reason(parsed):
    name, point, peak, reason = parsed.table("Rejected hits").rows[1]
    assert (name, point, reason) == ("rejected_1", "6", "peak force 6.0 N is below 10 N")
    assert float(peak) == pytest.approx(6.0, rel=0.01)


def test_the_shapes_move_only_for_those_who_let_them(page):
    assert "prefers-reduced-motion" in page
    assert "<button" in page
    assert "@media print" in page
    assert "prefers-color-scheme:dark" in page


def test_names_from_files_are_text_and_nothing_else(slim):
    rig = figure_data.rig(name=EVIL)
    channels = [c.model_copy(update={"serial": EVIL}) for c in rig.channels]
    campaign = replace(slim.campaign, rig=rig.model_copy(update={"channels": tuple(channels)}), source=EVIL)
    impact = slim.outcomes[0]
    hit = ReportedHit(EVIL, 6, impact.example.force, 2000.0, False, EVIL)
    block = replace(impact.example.block, name=EVIL)
    model = impact.model.model_copy(update={"notes": (EVIL,)})
    outcome = replace(impact, model=model, hits=(hit,), example=replace(impact.example, block=block))
    reported = {"title": EVIL, "campaign": campaign, "notes": (EVIL,), "provenance": {EVIL: EVIL}}
    text = render(replace(slim, outcomes=(outcome,), **reported))
    parsed = Page(text)
    assert len(parsed.all("script")) == 1, "the one that moves the shapes"
    assert "alert(1)</script>" not in text
    # Title and heading, rig, 11 serials, the record, the hit and its reason, the note, note of the model, provenance.
    assert parsed.text.count(EVIL) == 2 + 1 + 11 + 1 + 2 + 1 + 1 + 3


@pytest.mark.thorough("renders a whole report once more")
def test_channel_names_from_files_are_text_in_figures_too(content):
    check = content.outcomes[0].verification
    evil = {"outputs": ("<b>$x$", *check.measured.outputs[1:]), "output_points": (None,) * 10}
    named = replace(
        check,
        measured=replace(check.measured, **evil),
        regenerated=replace(check.regenerated, **evil),
        untruncated=replace(check.untruncated, **evil),
    )
    parsed = Page(render(replace(content, outcomes=(replace(content.outcomes[0], verification=named),))))
    assert "Channel <b>$x$ · FRAC" in parsed.text
    assert len(parsed.all("b")) == 3, "only the captions of the moving shapes are bold"


def test_one_sensor_at_no_place_and_no_sine_test(content):
    outcome = content.outcomes[0]
    one = figure_data.rig(
        model="unknown",
        beam=None,
        points=(),
        shaker_point=None,
        channels=[
            {"index": 0, "name": "force", "quantity": "force", "unit": "N"},
            {"index": 1, "name": "a01", "quantity": "acceleration", "unit": "m/s^2"},
        ],
    )
    model = outcome.model.model_copy(
        update={
            "outputs": ("a01",),
            "output_points": (None,),
            "input_points": (None,),
            "modal_constants": outcome.model.modal_constants[:, :1],
            "modal_constant_sigma": outcome.model.modal_constant_sigma[:, :1],
            "residuals": outcome.model.residuals[:, :1],
            "shapes": None,
            "shape_sigma": None,
            "shapes_unavailable": "no shapes: only one sensor",
        }
    )
    check = outcome.verification
    lone = OutcomeOfTest(
        "impact",
        model,
        _first(outcome.frf),
        replace(
            check,
            measured=_first(check.measured),
            regenerated=_first(check.regenerated),
            untruncated=_first(check.untruncated),
            frac=check.frac[:1],
        ),
        replace(outcome.example, responses=outcome.example.responses[:1], outputs=("a01",)),
        outcome.filtered[:1],
    )
    parsed = Page(render(ReportContent("One", replace(content.campaign, rig=one, blocks=()), (lone,))))
    assert "shapes" not in parsed.sections
    absent = parsed.sections["absent"]
    assert "There is no sine test in this campaign." in absent
    assert "no shapes: only one sensor" in absent
    assert "The true modes are not known" in absent
    assert "no calibration date for any channel" in absent
    assert "Channel a01" in parsed.text


def _first(frf):
    coherence = None if frf.coherence is None else frf.coherence[:1]
    return replace(
        frf,
        values=frf.values[:1],
        outputs=("a01",),
        output_points=(None,),
        input_points=(None,),
        coherence=coherence,
    )


def test_nothing_but_a_rig_still_makes_a_page(content):
    bare = ReportContent("Nothing yet", replace(content.campaign, blocks=()))
    parsed = Page(render(bare))
    assert "No modal model could be identified" in parsed.text
    assert set(parsed.sections) >= {"absent", "rig"}


def test_a_failed_identification_is_reported_with_its_reason(content):
    failed = OutcomeOfTest("impact", missing="The impact test could not be identified: the force channel is dead.")
    parsed = Page(render(replace(content, outcomes=(failed,))))
    assert "the force channel is dead" in parsed.sections["absent"]
    assert "There are no time signals to draw for the impact test." in parsed.sections["absent"]


def test_no_mode_in_the_band_is_said_in_plain_words(content):
    empty = figure_data.model(
        frequency_hz=[],
        damping_ratio=[],
        frequency_sigma_hz=[],
        damping_sigma=[],
        modal_constants=np.zeros((0, 10, 1), complex),
        modal_constant_sigma=np.zeros((0, 10, 1)),
        shapes=None,
        shape_sigma=None,
        half_power=[],
        half_power_floor=[],
        notes=("No pole was stable.",),
    )
    outcome = replace(content.outcomes[0], model=empty, verification=None)
    parsed = Page(render(replace(content, outcomes=(outcome,))))
    assert "No mode was found between 3 and 110 Hz." in parsed.text
    assert "No pole was stable." in parsed.sections["modes"]
    assert "half-power" not in parsed.sections


def test_unknown_uncertainties_are_said_not_hidden(slim):
    blind = figure_data.model(
        frequency_sigma_hz=[nan] * 3,
        damping_sigma=[nan] * 3,
        modal_constant_sigma=np.full((3, 10, 1), nan),
        shape_sigma=None,
        half_power=[nan] * 3,
        half_power_floor=[nan] * 3,
    )
    parsed = Page(render(replace(slim, outcomes=(replace(slim.outcomes[0], model=blind),))))
    assert "4.803 (± unknown)" in parsed.text
    assert "not readable" in parsed.text
    assert "nan" not in re.sub(r"[a-z]nan|nan[a-z]", "", parsed.text.lower())


def test_long_facts_are_folded_away_whole(slim):
    parsed = Page(render(replace(slim, provenance={"shapes": "0.123, " * 100})))
    assert "0.123, " * 100 in parsed.text


@pytest.mark.thorough("renders a whole report twice")
def test_the_page_is_small_quick_and_the_same_again(page, content):
    assert len(page.encode()) < 1.5e6
    start = time.process_time()
    svg_panels(panel_grid(10, 2)[0], "bare", "ten empty panels", 2)
    bare_s = time.process_time() - start
    again = render(content)
    assert time.process_time() - start - bare_s < 15 * bare_s, "it takes longer than its pictures need"
    assert again == page


def test_a_report_is_written_whole_or_not_at_all(tmp_path, content):
    bare = ReportContent("Nothing yet", replace(content.campaign, blocks=()))
    target = tmp_path / "report.html"
    write_report(target, bare)
    assert target.read_text(encoding="utf-8") == render(bare)
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]
    with pytest.raises(StorageError, match="missing"):
        write_report(tmp_path / "missing" / "report.html", bare)


def test_the_page_begins_with_what_is_good_and_what_is_to_be_looked_at(content, slim, parsed):
    marks = [a["class"] for a in parsed.all("li") if a.get("class") in ("good", "look")]
    assert marks.count("good") >= 3
    impact = content.outcomes[0]
    poor = replace(impact.verification, frac=np.where(np.arange(10)[:, None] == 4, 0.31, impact.verification.frac))
    page = Page(render(replace(slim, outcomes=(replace(slim.outcomes[0], verification=poor),))))
    assert "look" in [a.get("class") for a in page.all("li")]
    said = "At some points the model does not reproduce the measurement of the impact test: FRAC is down to 0.3100"
    assert said in page.text


def test_details_are_folded_and_a_link_leads_into_them(parsed):
    folded = [a["id"] for a in parsed.all("section") if a.get("class") == "folded"]
    assert "provenance" in folded
    assert "modes" not in folded
    linked = {a["href"][1:] for a in parsed.all("a")}
    assert {f"{name}-unfolded" for name in folded} <= linked
