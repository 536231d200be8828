/** The gap: where simulation and bench differ, why, how sure that is, what to measure next; and putting it into the simulation. */

import { get, post } from "../api.js";
import { button, h, panel, put, sentence } from "../dom.js";
import { budget, candidates, described, residuals, shrink, where } from "../gap-parts.js";
import { newestJob, waitForJob } from "../jobs.js";
import { command, lab } from "../lab.js";
import { clock, number } from "../numbers.js";
import { revisions } from "../revisions.js";

const VERDICTS = { no_gap: "Simulation and bench agree.", known: "The gap has a known cause.", unknown: "There is a gap, and no effect of the catalogue explains it." };

export async function show(view, signal, [wanted]) {
  const campaigns = (await get(`campaigns?limit=50${wanted ? "" : `&rig=${encodeURIComponent(lab.rig.id)}`}`)).items.filter(({ runs }) => runs.length);
  const choice = h("select", { id: "campaign", onchange: () => { location.hash = `#/gap/${choice.value}`; } }, campaigns.map((one) => h("option", { value: one.id }, `${one.name}, ${clock(one.created_utc)}`)));
  if (wanted) choice.value = wanted;
  const place = h("div");
  put(view, h("h1", {}, "Gap between simulation and bench"), campaigns.length ? h("p", { class: "buttons" }, h("label", { for: "campaign" }, "Campaign"), choice) : h("p", {}, "There are no recordings yet: begin a test."), place, await revisions(signal));
  if (choice.value) await draw(place, campaigns.find(({ id }) => id === choice.value), signal);
}

async function draw(place, campaign, signal) {
  const { id } = campaign;
  const jobs = await newestJob(id, "diagnose");
  const waiting = h("p", { class: "muted", role: "status" }, jobs.last?.state === "failed" ? `The last diagnosis failed: ${jobs.last.error}` : "");
  const bar = h("progress", { max: 1, value: 0, hidden: true, "aria-label": "Progress of the diagnosis" });
  const follow = async (job) => {
    bar.hidden = false;
    waiting.textContent = "The diagnosis takes minutes. This page need not stay open.";
    await waitForJob(job, ({ progress, stage }) => {
      bar.value = progress;
      if (stage) waiting.textContent = `Being diagnosed: ${stage}. This page need not stay open.`;
    }, signal);
    if (!signal.aborted) await draw(place, campaign, signal);
  };
  const diagnose = (text) => button(text, async () => follow((await post(`campaigns/${id}/diagnoses`)).id));
  if (jobs.open) follow(jobs.open.id).catch((error) => { waiting.textContent = error.detail ?? ""; });
  if (!jobs.done) { put(place, panel("No diagnosis yet", waiting, bar, !jobs.open && h("p", { class: "buttons" }, diagnose("Diagnose")))); return; }
  const { diagnosis, sentence: said, numbers, current, runs } = await get(`campaigns/${id}/gap`);
  if (signal.aborted) return;
  put(place, waiting, bar, !current && h("p", { class: "alarm" }, "The accepted blocks have changed since: compute the diagnosis again.", diagnose("Diagnose again")),
    verdict(said, diagnosis, campaign, runs), h("div", { class: "pair" }, where({ ...diagnosis.where, x_m: diagnosis.where.x_m ?? diagnosis.described?.x_m ?? null }), diagnosis.verdict === "known" && shrink(diagnosis.shrink)), described(diagnosis.described, numbers), candidates(diagnosis.candidates, diagnosis.unknown), h("div", { class: "pair" }, residuals(diagnosis.gap), budget(diagnosis.budget)));
}

function verdict(said, { verdict: found, effects, gap, next_experiment: next, notes }, campaign, runs) {
  return h("section", { class: "panel", "aria-label": "Verdict" }, h("p", { class: "verdict" }, VERDICTS[found]),
    h("p", {}, said),
    effects.length > 0 && h("p", {}, `With ${effects.length > 1 ? "these effects" : "this effect"} in the simulation ${number(gap.after, 3)} noise units remain; 1 is noise alone.`),
    next && h("p", {}, h("strong", {}, "Next: "), sentence(spaced(next))), notes.length > 0 && h("ul", { class: "plainlist" }, notes.map((note) => h("li", {}, spaced(note)))),
    h("p", { class: "buttons" }, found === "known" && button("Add this to the simulation", () => apply(campaign.id), { class: "main" }),
      runs.filter(kindOf).map((run) => h("a", { class: "button", href: `#/${kindOf(run)}/${run}` }, `Run the ${kindOf(run)} test again`)),
      h("a", { href: `/api/v1/campaigns/${campaign.id}/diagnosis`, target: "_blank", rel: "noopener" }, "The whole diagnosis as a page")));
}

const spaced = (text) => text.replaceAll("_", " ");

/** The view of what a run tested, which stands in its name. */
const kindOf = (run) => (/-(random|burst-random|pseudo-random|chirp)-/.test(run) ? "broadband" : /-(impact|sine)-/.exec(run)?.[1]);

/** The next revision of the rig; the view shows it in the history as soon as the bench is open again. */
async function apply(campaign) {
  await command(`campaigns/${campaign}/gap/apply`);
}
