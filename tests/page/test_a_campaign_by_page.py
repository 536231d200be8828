"""What an operator does from the first hit to the corrected simulation, in a real browser on the simulated bench."""

import base64
from collections.abc import Callable, Iterator

import pytest
from axe_playwright_python.sync_playwright import Axe
from page_browser import Watched
from playwright.sync_api import Browser
from service_process import ServiceProcess

Open = Callable[..., Watched]
VIEWS = ("Bench", "Impact test", "Sine test", "Model", "Gap", "Campaigns")
SEEN = {"Model": "canvas.diagram", "Gap": ".verdict"}
SERIOUS = ("serious", "critical")
IMPACT = {"impact-points": "10, 6", "impact-hits": "2", "impact-rate_hz": "1000"}
DONE = ".prompt .large:text-is('Done')"
SAID = """selector => { window.said = []; const seen = () => document.querySelector(selector)
    && window.said.push(document.querySelector(selector).textContent);
    new MutationObserver(seen).observe(document.body, {childList: true, subtree: true, characterData: true}); }"""
HIT = "section[aria-label='The last hit'] .large"
DROP = """([name, content]) => {
    const bytes = Uint8Array.from(atob(content), one => one.charCodeAt(0));
    const files = new DataTransfer();
    files.items.add(new File([bytes], name));
    const drop = new DragEvent("drop", {dataTransfer: files, bubbles: true, cancelable: true});
    document.querySelector(".drop").dispatchEvent(drop); }"""
POLE = """async ([campaign, mode]) => {
    const {tests: [{diagram: d}]} = await (await fetch(`/api/v1/campaigns/${campaign}/curves`)).json();
    const {models: [{model}]} = await (await fetch(`/api/v1/campaigns/${campaign}/model`)).json();
    const canvas = document.querySelector("canvas.diagram");
    const scale = canvas.clientWidth / canvas.width;
    const [low, high] = [Math.min(...d.line_hz), Math.max(...d.line_hz)];
    const [least, most] = [Math.min(...d.order), Math.max(...d.order)];
    const n = d.frequency_hz.findIndex((hz, i) => d.standing[i] === 2 && d.order[i] > (least + most) / 2
        && Math.abs(hz - model.frequency_hz[mode]) < 0.5);
    return {x: scale * (44 + (d.frequency_hz[n] - low) / (high - low) * (canvas.width - 60)),
        y: scale * (canvas.height - 34 - (d.order[n] - least) / (most - least) * (canvas.height - 56))}; }"""


def decide(ada: Watched) -> None:
    """Say of each hit whether it counts: the rejected ones do not, nor does the first good one."""
    page, undone, asked = ada.page, False, ""
    while True:
        page.wait_for_selector(f"{DONE}, .prompt[data-asked]:not([data-asked='']):not([data-asked='{asked}'])")
        if page.query_selector(DONE):
            return
        asked = page.get_attribute(".prompt[data-asked]", "data-asked")
        good = page.inner_text(HIT) == "Good"
        if good and not undone:
            ada.picture("impact", whole=False)
        page.keyboard.press("PageDown" if good and undone else "PageUp")
        undone |= good


@pytest.fixture(scope="module")
def recorded(browser: Browser, served: ServiceProcess) -> Iterator[Watched]:
    """The page of whoever did an impact test; the pedal said of each hit whether it counts, and undid a good one."""
    ada = Watched(browser, served.url + served.client.login_link().path, viewport={"width": 1360, "height": 860})
    ada.view("Impact test")
    ada.page.evaluate(SAID, HIT)
    ada.page.click("text=All settings")
    ada.page.click("summary:has-text('Precision')")
    ada.page.check("details:has(> summary:has-text('Precision')) > label input")
    ada.page.select_option("#f-impact-operator_decides", "every")
    ada.picture("plan")
    ada.begin("Impact test", IMPACT)
    decide(ada)
    yield ada
    ada.close()
    assert ada.wrong == []


@pytest.fixture(scope="module")
def campaign(recorded: Watched, served: ServiceProcess) -> str:
    return served.client.campaigns()[0].id


@pytest.fixture(scope="module")
def corrected(recorded: Watched, campaign: str, served: ServiceProcess) -> Watched:
    """The page once that test was diagnosed, its cause put into the simulation, and the test done again."""
    page = recorded.page
    page.evaluate("campaign => { location.hash = `#/gap/${campaign}`; }", campaign)
    page.click("button:text-is('Diagnose')")
    page.wait_for_selector(".verdict:text-is('The gap has a known cause.')")
    assert "added mass at 0.4" in page.inner_text("section[aria-label='Verdict']")
    page.click("text=Add this to the simulation")
    page.wait_for_selector("td:has-text('added mass, as diagnosed in')")
    served.client.wait_until_idle(served.rig)
    recorded.picture("gap")
    page.click("text=Run the impact test again")
    page.wait_for_selector("form.plan p.good")
    assert page.input_value("#f-impact-points") == "10, 6"
    page.fill("#f-impact-points", "10")
    page.select_option("#f-impact-operator_decides", "never", force=True)
    page.click("form.plan button.main:enabled")
    page.wait_for_selector(DONE)
    return recorded


def test_a_whole_impact_test_with_a_bad_hit_and_an_undone_one(recorded: Watched, served: ServiceProcess) -> None:
    page = recorded.page
    # This bench strikes so soon that its next hit may stand where "Undone" would be read.
    assert {"Good", "Rejected"} <= set(page.evaluate("window.said"))
    assert page.inner_text(".togo").startswith("4 of 4 good hits")
    page.wait_for_selector("[aria-label='FRFs so far'][data-points='10 6'][data-averages='2']")
    run = served.client.campaigns()[0].runs[-1]
    assert served.client.run(run).accepted == 4
    assert "undone by the operator" in [block.reason for block in served.client.blocks(run)]


def test_the_modes_so_far_say_when_it_is_enough(recorded: Watched) -> None:
    recorded.page.wait_for_selector(".togo:has-text('Enough')")
    recorded.picture("modes-so-far")
    assert recorded.page.locator("[aria-labelledby=p-modes-so-far] tbody tr").count() >= 4


def test_the_page_says_during_the_test_whether_the_simulation_agrees(recorded: Watched) -> None:
    # A mass of 50 g hangs on this bench, and the rig file knows nothing of it.
    recorded.page.wait_for_selector(".warn:has-text('differ from the simulation')")
    said = recorded.page.inner_text("[aria-labelledby=p-modes-so-far]")
    assert "Natural frequencies differ from the simulation" in said


@pytest.mark.thorough("identifies again on the page")
def test_poles_are_chosen_on_the_diagram(recorded: Watched, campaign: str, served: ServiceProcess) -> None:
    recorded.view("Model")
    rows = recorded.page.locator("[aria-labelledby=p-modes-of-the-impact-test] tbody tr")
    recorded.page.wait_for_selector("canvas.diagram")
    # The diagram may be drawn before the table is.
    rows.first.wait_for()
    modes = rows.count()
    recorded.page.click("canvas.diagram", position=recorded.page.evaluate(POLE, [campaign, 2]))
    listed = "Those of the model are listed as refined, other poles that hold as the estimator found them."
    recorded.page.wait_for_selector(f"text='{modes - 1} chosen. {listed}'")
    recorded.page.click("text=Identify with these poles only")
    recorded.page.wait_for_function(
        "n => document.querySelectorAll('[aria-labelledby=p-modes-of-the-impact-test] tbody tr').length === n",
        arg=modes - 1,
    )
    picked = served.client.jobs(campaign, "identify")[0].parameters["pick_hz"]
    assert isinstance(picked, list)
    assert len(picked) == modes - 1
    for picture in ("phase", "real", "imaginary", "nyquist", "amplitude"):
        recorded.page.select_option("#regenerated-impact-Picture", picture)
        recorded.page.wait_for_selector(".uplot")
    recorded.page.wait_for_selector("[role=status]:has-text('This pair is off by')")
    recorded.picture("model")


def test_a_click_on_a_point_hangs_a_mass_there(recorded: Watched) -> None:
    recorded.view("Model")
    recorded.page.click(".work .pick[aria-label='Add at point 10'] circle")
    rows = recorded.page.locator("[aria-label='Modes before and after'] tbody tr")
    rows.first.wait_for()
    shift, _, sigma = rows.first.locator("td").nth(2).inner_text().partition("(")
    assert float(shift.replace("−", "-")) < -1
    assert sigma.endswith(")")
    recorded.picture("workbench")
    recorded.page.wait_for_selector("canvas[aria-label^='Shapes before and after']")
    with recorded.page.expect_download() as saved:
        recorded.page.click("text=Save the plan")
    plan = saved.value.path().read_text()
    assert "mass 0.05 kg at 10" in plan
    assert '"kind":"impact"' in plan


def test_the_best_absorber_of_a_mode_is_hung_by_a_click(recorded: Watched) -> None:
    recorded.view("Model")
    # What an earlier click hung there stays.
    recorded.page.wait_for_selector(".work .pick")
    recorded.page.select_option("#work-impact-kind", "absorber")
    recorded.page.select_option("select[aria-label='Mode of the absorber']", "2")
    recorded.page.click(".work .pick[aria-label='Add at point 10'] circle")
    recorded.page.wait_for_selector(".plainlist li:has-text('absorber 0.05 kg')")


def test_a_shape_turns_and_a_finite_element_model_is_corrected(recorded: Watched) -> None:
    # From another view: else what is clicked on may be the former drawing of this one.
    recorded.view("Campaigns")
    recorded.page.wait_for_selector("h1:has-text('Campaigns')")
    recorded.view("Model")
    canvas = "canvas[aria-label^='Shape of a mode of the impact test']"
    recorded.page.uncheck("label:has-text('moves') input >> nth=0")
    look = f'document.querySelector("{canvas}").toDataURL()'
    recorded.page.wait_for_timeout(100)
    before = recorded.page.evaluate(look)
    recorded.page.press(canvas, "ArrowRight")
    recorded.page.wait_for_function(f"before => {look} !== before", arg=before)
    recorded.page.click("[aria-labelledby=p-finite-element-model-impact] button:has-text('Estimate')")
    rows = recorded.page.locator("[aria-labelledby=p-finite-element-model-impact] [aria-label=Parameters] tbody tr")
    rows.first.wait_for()
    assert "youngs modulus [Pa]" in rows.first.inner_text()


@pytest.mark.thorough("diagnoses on the page, and tests again")
def test_a_diagnosis_is_put_into_the_simulation(corrected: Watched, served: ServiceProcess) -> None:
    corrected.page.wait_for_selector(DONE)
    assert served.client.campaigns()[0].name.endswith(", revision 2")


@pytest.mark.thorough("diagnoses on the page, and tests again")
def test_two_runs_are_laid_over_each_other(corrected: Watched, campaign: str, served: ServiceProcess) -> None:
    page = corrected.page
    run = served.client.campaigns()[0].runs[-1]
    corrected.view("Model")
    page.wait_for_selector("canvas.diagram")
    corrected.view("Campaigns")
    page.click("button[aria-label$='revision 2']")
    page.check(f"input[value='{run}']")
    page.click("main tbody tr:nth-child(2) button")
    page.check(f"input[value='{served.client.campaign(campaign).runs[0]}']")
    page.click("text=Compare two runs")
    page.wait_for_selector("[aria-label='Modes of both runs'] tbody tr:nth-child(3)")
    mac = page.locator("[aria-label='Modes of both runs'] tbody tr td:last-child").all_inner_texts()
    corrected.picture("campaigns")
    assert all(float(one) > 0.99 for one in mac[:3])


@pytest.mark.thorough("diagnoses on the page, and tests again")
def test_what_was_exported_comes_back_by_a_drop(corrected: Watched, campaign: str, served: ServiceProcess) -> None:
    page = corrected.page
    corrected.view("Campaigns")
    page.click("main tbody tr:nth-child(2) button")
    with page.expect_download() as exported:
        page.click("button:text-is('Export')")
    content = exported.value.path().read_bytes()
    page.evaluate(DROP, ["again.h5", base64.b64encode(content).decode()])
    page.wait_for_selector(".drop p:text-is('again.h5 is there.')")
    again = served.client.campaigns()[0]
    assert again.name == "again.h5"
    assert served.client.run(again.runs[0]).accepted == 4
    page.evaluate(DROP, ["broken.h5", base64.b64encode(b"no campaign").decode()])
    page.wait_for_selector(".drop p:text-is('broken.h5 was not taken.')")
    assert "To correct it" in page.inner_text(".message")
    page.click("button[aria-label='Close this message']")
    corrected.wrong.clear()  # The browser says itself that a request was rejected.


@pytest.mark.thorough("diagnoses on the page, and tests again")
def test_a_report_opens_beside_the_page(corrected: Watched) -> None:
    corrected.view("Campaigns")
    corrected.page.click("button[aria-label$='revision 2']")
    with corrected.page.expect_popup() as report:
        corrected.page.click("button:text-is('Report')")
    report.value.wait_for_selector("h1:has-text('Modal test of')")
    report.value.close()


def show(recorded: Watched, view: str, campaign: str) -> None:
    """A view with something to see in it."""
    recorded.view(view)
    if view in SEEN:
        recorded.page.evaluate(f"location.hash = '#/{view.lower()}/{campaign}'")
    recorded.page.wait_for_selector(SEEN.get(view, "main section.panel, main .prompt"))


@pytest.mark.thorough("diagnoses on the page, and tests again")
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_everybody_can_read_every_view(corrected: Watched, campaign: str, scheme: str) -> None:
    corrected.page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
    for view in VIEWS:
        show(corrected, view, campaign)
        if (view, scheme) == ("Model", "dark"):
            corrected.picture("dark")
        found = Axe().run(corrected.page).response["violations"]
        assert [(one["id"], one["nodes"][0]["html"]) for one in found if one["impact"] in SERIOUS] == [], view


@pytest.mark.thorough("diagnoses on the page, and tests again")
def test_at_1440_pixels_no_table_is_wider_than_its_card(corrected: Watched, campaign: str) -> None:
    corrected.page.set_viewport_size({"width": 1440, "height": 900})
    for view in VIEWS:
        show(corrected, view, campaign)
        wide = corrected.page.evaluate(
            "[...document.querySelectorAll('.scroll')].filter(one => one.scrollWidth > one.clientWidth)"
            ".map(one => one.getAttribute('aria-label'))"
        )
        assert wide == [], view


@pytest.mark.thorough("diagnoses on the page, and tests again")
def test_on_a_phone_nothing_is_wider_than_the_screen(corrected: Watched, campaign: str) -> None:
    corrected.page.set_viewport_size({"width": 390, "height": 800})
    for view in VIEWS:
        show(corrected, view, campaign)
        assert corrected.page.evaluate("document.documentElement.scrollWidth") <= 390, view
        assert corrected.page.is_visible("button.stop")
        if view == "Gap":
            corrected.picture("phone", whole=False)
