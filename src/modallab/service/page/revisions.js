/** The history of the rig: what it was believed to be, and how its simulation came closer to the bench. */

import { get } from "./api.js";
import { Chart, look } from "./charts.js";
import { h, panel, put, table } from "./dom.js";
import { lab, watch } from "./lab.js";
import { clock, number } from "./numbers.js";

/** A panel that follows the rig's revisions. */
export async function revisions(signal) {
  const [list, curve] = [h("div"), h("div")];
  const chart = new Chart({ name: "Gap of the simulation after each applied diagnosis", x: "Applied diagnoses", y: "Gap [noise units]", log: true, height: 200, points: true, whole: true });
  signal.addEventListener("abort", () => chart.close());
  let shown = "";
  async function draw() {
    const { items } = await get(`rigs/${lab.rig.id}/revisions`);
    if (signal.aborted) return;
    put(list, table("Revisions of the rig", [["Revision", "n"], "Since", "By", "Why"], items.map((one) => [one.number, clock(one.utc), one.operator || "–", h("span", { class: "words" }, one.reason)])));
    const steps = lab.description.revisions ?? [];
    put(curve, steps.length > 0 && chart.element, steps.map((one) => h("p", {}, h("strong", {}, one.effects.map(({ effect }) => effect.replaceAll("_", " ")).join(" and ")), `, ${one.applied_on}: from ${number(one.before, 3)} to ${number(one.after, 3)} noise units on held-out records. ${one.source}`)));
    if (steps.length) chart.draw([{ label: "gap", ...look(0) }], [[0, ...steps.map((_, n) => n + 1)], [steps[0].before, ...steps.map(({ after }) => after)]]);
  }
  watch(() => {
    if (shown === lab.rig.rig_hash) return;
    shown = lab.rig.rig_hash;
    draw().catch(() => { shown = ""; });
  }, signal);
  return panel("Revisions of this rig", list, curve);
}
