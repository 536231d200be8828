/** The gap: where simulation and bench differ, why, how sure that is, and what to measure next. */

import { get, post } from "../api.js";
import { button, h, panel, put, sentence, svg, table } from "../dom.js";
import { newestJob, waitForJob } from "../jobs.js";
import { lab } from "../lab.js";
import { clock, number, percent } from "../numbers.js";

const STAGES = ["excitation", "structure", "sensor", "acquisition"];
const VERDICTS = { no_gap: "Simulation and bench agree.", known: "The gap has a known cause.", unknown: "There is a gap, and nothing in the catalogue explains it." };

export async function show(view, signal, [wanted]) {
  const campaigns = (await get(`campaigns?limit=50${wanted ? "" : `&rig=${encodeURIComponent(lab.rig.id)}`}`)).items.filter(({ runs }) => runs.length);
  const choice = h("select", { id: "campaign", onchange: () => { location.hash = `#/gap/${choice.value}`; } }, campaigns.map((one) => h("option", { value: one.id }, `${one.name}, ${clock(one.created_utc)}`)));
  if (wanted) choice.value = wanted;
  const place = h("div");
  put(view, h("h1", {}, "Gap between simulation and bench"), campaigns.length ? h("p", { class: "buttons" }, h("label", { for: "campaign" }, "Campaign"), choice) : h("p", {}, "Nothing is recorded yet: begin a test."), place);
  if (choice.value) await draw(place, choice.value, signal);
}

async function draw(place, id, signal) {
  const jobs = await newestJob(id, "diagnose");
  const waiting = h("p", { class: "muted", role: "status" }, jobs.last?.state === "failed" ? `The last one failed: ${jobs.last.error}` : "");
  const follow = async (job) => {
    await waitForJob(job, () => { waiting.textContent = "The gap is being diagnosed; that takes minutes. This page need not stay open."; }, signal);
    if (!signal.aborted) await draw(place, id, signal);
  };
  const diagnose = (text) => button(text, async () => follow((await post(`campaigns/${id}/diagnoses`)).id));
  if (jobs.open) follow(jobs.open.id).catch((error) => { waiting.textContent = error.detail ?? ""; });
  if (!jobs.done) { put(place, panel("No diagnosis yet", waiting, !jobs.open && h("p", { class: "buttons" }, diagnose("Diagnose")))); return; }
  const { diagnosis, current } = await get(`campaigns/${id}/gap`);
  if (signal.aborted) return;
  put(place, waiting, !current && h("p", { class: "alarm" }, "Other blocks count by now: order the diagnosis anew.", diagnose("Diagnose anew")),
    verdict(diagnosis, id), h("div", { class: "pair" }, where(diagnosis.where), shrink(diagnosis)), candidates(diagnosis.candidates), h("div", { class: "pair" }, channels(diagnosis.gap), budget(diagnosis.budget)));
}

function verdict({ verdict: found, effects, gap, next_experiment: next, notes }, id) {
  return h("section", { class: "panel", "aria-label": "Verdict" }, h("p", { class: "verdict" }, VERDICTS[found]),
    effects.map((one) => h("p", {}, h("strong", {}, one.effect.replaceAll("_", " ")), `${one.place.x_m === undefined ? "" : ` at ${number(one.place.x_m, 3)} m`}, probability ${number(one.probability, 2)}: `,
      Object.entries(one.parameters).map(([name, value]) => `${name.replaceAll("_", " ")} = ${number(value)}${one.interval[name] ? ` (95 %: ${number(one.interval[name][0])} to ${number(one.interval[name][1])})` : ""}`).join(", "))),
    h("p", {}, `The gap is ${number(gap.before, 3)} noise units${effects.length ? `, and ${number(gap.after, 3)} with ${effects.length > 1 ? "these effects" : "this effect"} in the model` : ""}; 1 is noise alone.`),
    next && h("p", {}, h("strong", {}, "Next experiment: "), sentence(next)), notes.length > 0 && h("ul", { class: "plainlist" }, notes.map((note) => h("li", {}, note))),
    h("p", { class: "buttons" }, h("a", { href: `/api/v1/campaigns/${id}/diagnosis`, target: "_blank", rel: "noopener" }, "The whole diagnosis as a page"), h("a", { href: "#/impact" }, "Begin the next impact test"), h("a", { href: "#/sine" }, "Begin the next sine test")));
}

function where({ stage, x_m: x, channels: rows, why, share }) {
  const points = lab.description.points;
  const length = lab.description.beam?.length_m ?? Math.max(...points.map(({ x_m: at }) => at));
  const at = (place) => 30 + (place / length) * 580;
  return panel("Where", h("ol", { class: "chain", "aria-label": "Stages of the measurement" }, STAGES.map((one) => h("li", { "aria-current": one === stage && "true" }, one))),
    svg("svg", { viewBox: "0 0 640 80", class: "beam", role: "img", "aria-label": x === null ? "The beam; the gap has no place on it" : `The beam; the gap lies at ${number(x, 3)} m` },
      svg("rect", { class: "body", x: 30, y: 40, width: 580, height: 8 }), points.map(({ id, x_m: place }) => svg("text", { x: at(place), y: 68 }, String(id))),
      x !== null && svg("circle", { class: "point next", cx: at(x), cy: 44, r: 10 }), x !== null && svg("text", { class: "next", x: at(x), y: 24 }, `${number(x, 3)} m`)),
    rows.length > 0 && h("p", {}, `Channels: ${rows.join(", ")}. They hold ${percent(share, 2)} of it.`), h("ul", { class: "plainlist" }, why.map((one) => h("li", {}, sentence(one)))));
}

function shrink({ shrink: found }) {
  const rows = [["Gap before", `${number(found.before, 3)} noise units`], ["Gap after", `${number(found.after, 3)} noise units`], ["Closed", found.closed === null ? "–" : `${percent(found.closed, 3)}${found.interval ? ` (95 %: ${percent(found.interval[0], 3)} to ${percent(found.interval[1], 3)})` : ""}`],
    ...Object.entries(found.rival).map(([name, value]) => [`Best other: ${name.replaceAll("_", " ")}`, percent(value, 3)])];
  return panel("On records that no fit has seen", table("How far the gap shrinks", ["", ["", "n"]], rows), h("p", { class: "muted" }, `${found.held_out.length} records were held out.`));
}

const bar = (share) => h("span", { class: "bar" }, h("meter", { min: 0, max: 1, value: Math.max(0, Math.min(1, share)), "aria-label": `${number(100 * share, 3)} percent` }), ` ${percent(share, 2)}`);

const candidates = (found) => panel("Candidates", found.length ? table("Candidates with their probability", ["Explanation", "Probability", ["Gap it leaves", "n"]], found.slice(0, 8).map((one) => [one.effects.join(" and ").replaceAll("_", " ") || "none", bar(one.probability), `${number(one.gap, 3)}`])) : h("p", { class: "muted" }, "There are none."));

const channels = ({ by_channel: before, after_by_channel: after }) => panel("Residual before and after", table("Residual by channel, in noise units", ["Channel", ["Before", "n"], ["After", "n"]], Object.keys(before).map((name) => [name, number(before[name], 3), number(after[name], 3)])));

const budget = (found) => panel("Budget", found ? [table("Parts of the gap", ["Part", "Share", ["Sigmas", "n"]], found.rows.slice(0, 12).map((row) => [`${row.name.replaceAll("_", " ")}${row.place ? `, ${row.place}` : ""}`, bar(row.share), number(row.sigmas, 2)])),
  h("ul", { class: "plainlist" }, found.calibrate.map((one) => h("li", {}, sentence(one))))] : h("p", { class: "muted" }, "This diagnosis has none."));
