/** The modal model: poles to choose, modes with their uncertainty, shapes that move, measured against regenerated. */

import { find, get, post } from "../api.js";
import { button, h, panel, put, table } from "../dom.js";
import { newestJob, waitForJob } from "../jobs.js";
import { lab } from "../lab.js";
import { clock, number, uncertain } from "../numbers.js";
import { onEvent } from "../events.js";
import { Stabilisation } from "../stabilisation.js";
import { Regenerated } from "../regenerated.js";
import { ShapeView } from "../shape.js";
import { Update } from "../update.js";
import { Workbench } from "../workbench.js";

export async function show(view, signal, [wanted]) {
  const campaigns = (await get(`campaigns?limit=50${wanted ? "" : `&rig=${encodeURIComponent(lab.rig.id)}`}`)).items.filter(({ runs }) => runs.length);
  const place = h("div");
  const choice = h("select", { id: "campaign", onchange: () => { location.hash = `#/model/${choice.value}`; } }, campaigns.map((one) => h("option", { value: one.id }, `${one.name}, ${clock(one.created_utc)}`)));
  if (wanted) choice.value = wanted;
  put(view, h("h1", {}, "Model"), campaigns.length ? h("p", { class: "buttons" }, h("label", { for: "campaign" }, "Campaign"), choice) : h("p", {}, "There are no recordings yet: begin a test."), place);
  if (!choice.value) return;
  const id = choice.value;
  let inner = new AbortController();
  signal.addEventListener("abort", () => inner.abort());
  let shown;
  async function fill() {
    inner.abort();
    inner = new AbortController();
    const jobs = await newestJob(id, "identify");
    shown = jobs.done?.id;
    await draw(place, id, jobs, inner.signal, fill);
  }
  // Other jobs end as well: drawn anew for them, the view would lose their answers.
  onEvent(async (event) => { if (event.kind === "job" && event.campaign === id && event.content.state === "done" && (await newestJob(id, "identify")).done?.id !== shown) fill(); }, signal);
  await fill();
}

async function draw(place, id, jobs, signal, again) {
  const ordering = h("p", { class: "muted", role: "status" }, jobs.open ? "A model is being computed …" : jobs.last?.state === "failed" ? `The last diagnosis failed: ${jobs.last.error}` : "");
  async function identify(parameters = {}) {
    const job = await post(`campaigns/${id}/models`, { parameters });
    await waitForJob(job.id, () => { ordering.textContent = "A model is being computed …"; }, signal);
    await again();
  }
  if (!jobs.done) { put(place, panel("No model yet", ordering, h("p", { class: "buttons" }, button("Identify", () => identify())))); return; }
  const found = await get(`campaigns/${id}/model`);
  const curves = await find(`campaigns/${id}/curves`);
  const shapes = await Promise.all(found.models.map(({ model }) => shapesOf(id, model.test)));
  const sizes = await Promise.all(found.models.map(({ model }) => find(`campaigns/${id}/model/reduction${ofTest(model.test)}`)));
  if (signal.aborted) return;
  put(place, !found.current && h("p", { class: "alarm" }, "The accepted blocks have changed since: compute the model again.", button("Identify again", () => identify())), ordering,
    found.without_model.map(({ test, error }) => h("p", { class: "warn" }, `The ${test} test gave no model: ${error}`)),
    found.models.map((one, n) => modelPart(id, one, curves?.tests[n] ?? null, shapes[n], sizes[n], identify, signal)));
}

const ofTest = (test) => (test ? `?test=${test}` : "");

/** The structure and how it moves; why not, where nothing says where the points are. */
async function shapesOf(campaign, test) {
  try { return await get(`campaigns/${campaign}/model/shapes${ofTest(test)}`); } catch (error) { return { why: error.detail ?? error.message }; }
}

function modelPart(campaign, { model, frac, assessment }, curves, shapes, sizes, identify, signal) {
  const name = model.test ?? "FRFs";
  const modes = model.frequency_hz.map((_, n) => n);
  const heads = [["Mode", "n"], ["Frequency [Hz]", "n"], ["Damping [%]", "n"], ["Half-power [%]", "n"], ["Confidence", "n"], ["MPC", "n"], ["Phase deviation [°]", "n"]];
  const rows = modes.map((n) => [n + 1, uncertain(model.frequency_hz[n], model.frequency_sigma_hz[n]), uncertain(100 * model.damping_ratio[n], 100 * model.damping_sigma[n]),
    number(100 * model.half_power[n], 3), number(assessment?.confidence[n], 2), number(assessment?.mpc[n], 4), number((assessment?.mpd_rad[n] * 180) / Math.PI, 2)]);
  const frame = h("div", { class: "thirds" },
    h("div", {}, panel(`Modes of the ${name} test`, table(`Modes of the ${name} test`, heads, rows), h("p", { class: "muted" }, "4.80(3) stands for 4.80 ± 0.03, one standard deviation."), trust(frac, assessment, model))),
    h("div", {}, panel(`Shapes, ${name} test`, shapes.why ? h("p", {}, shapes.why) : new ShapeView(name, shapes, signal).element), assessment && macPanel(name, assessment.auto_mac)));
  const diagram = curves?.diagram ? new Stabilisation(name, curves.diagram, model, identify, signal).element : null;
  const played = curves?.measured && sizes ? new Regenerated(name, curves, sizes, signal).element : null;
  const used = model.shapes && !shapes.why ? [new Workbench(campaign, model, shapes, signal).element, new Update(campaign, model).element] : [];
  return [frame, diagram, played, used];
}

function trust(frac, assessment, model) {
  const values = (frac ?? []).flat().filter(Number.isFinite);
  return [values.length ? h("p", {}, `FRAC of the regenerated FRFs: at least ${Math.min(...values).toFixed(4)}.`) : null,
    h("ul", { class: "plainlist" }, (assessment?.verdicts ?? []).map((one) => h("li", { class: one.holds ? "" : "bad" }, `${one.holds ? "Holds" : "Does not hold"}: ${one.words}`)), model.notes.map((note) => h("li", {}, note)))];
}

function macPanel(name, mac) {
  const cell = (value) => {
    const shade = Math.round(4 * Math.max(0, Math.min(1, value)));
    return h("td", { class: `heat heat-${shade}` }, value === null ? "–" : value.toFixed(2));
  };
  return panel(`MAC, ${name} test`, h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": `MAC of the ${name} test` }, h("table", { class: "mac" }, h("caption", { class: "hidden" }, "MAC of each mode with each"),
    h("thead", {}, h("tr", {}, h("td"), mac.map((_, n) => h("th", { scope: "col", class: "heat" }, String(n + 1))))),
    h("tbody", {}, mac.map((row, n) => h("tr", {}, h("th", { scope: "row" }, String(n + 1)), row.map(cell)))))));
}

