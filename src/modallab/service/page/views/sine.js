/** The sine test: how far it is, what each frequency gave, and the FRF as it fills. */

import { Chart, look } from "../charts.js";
import { button, h, panel, put, sentence } from "../dom.js";
import { sayProgress, sayState, watchDrive } from "../driven.js";
import { GrowingFrf } from "../growing-frf.js";
import { lab } from "../lab.js";
import { number } from "../numbers.js";
import { order, runButtons, showTest } from "../test-view.js";

const form = { name: "SinePlan", kind: "sine", first: ["frequencies_hz", "levels_v", "settle_s", "wait_s"], start: () => ({ levels_v: { low: 0.5 } }) };

export const show = (view, signal, [like]) => showTest(view, signal, { like, test: "sine", title: "Sine test", form, parts });

function parts(place, signal, id) {
  const { limits } = lab.description;
  const [large, under] = [h("p", { class: "large" }), h("p", { class: "under" })];
  const prompt = h("section", { class: "prompt", "aria-label": "State of the test", "aria-live": "polite" }, large, under);
  const bar = h("progress", { max: 1, value: 0, "aria-label": "Progress of the test" });
  const left = h("p", { class: "under" });
  const common = runButtons(id);
  const drive = panel("Drive");
  const force = new Chart({ name: "Force at each frequency", x: "Frequency [Hz]", y: "Force [N]", height: 180, points: true, range: (_, low, high) => [0, Math.max(1e-6, high * 1.15 || 1)] });
  const list = h("tbody");
  const frequencies = h("div", { class: "scroll tall", tabindex: "0", role: "region", "aria-label": "Frequencies of the plan" }, h("table", {}, h("thead", {}, h("tr", {}, ["Level", "Frequency", "Force", "State", ""].map((head, n) => h("th", { scope: "col", class: n === 1 || n === 2 ? "n" : null }, head)))), list));
  signal.addEventListener("abort", () => force.close());
  const notices = h("div");
  const forces = h("section", { class: "panel", "aria-label": "Force" }, force.element);
  put(place, h("div", { class: "pair" }, prompt, h("section", { class: "prompt", "aria-label": "Progress" }, h("h2", {}, "Progress"), left, bar, h("p", { class: "buttons" }, common.elements), notices)),
    new GrowingFrf(id, signal, { points: true }).element,
    h("div", { class: "pair" }, h("section", { class: "panel", "aria-label": "Frequencies" }, h("h2", {}, "Frequencies"), frequencies), h("div", {}, drive, forces)));
  watchDrive(drive, limits, signal, "sine");

  return (state) => {
    sayState([large, under], prompt, state, (done, total) => `frequency ${Math.min(done + 1, total)} of ${total}`);
    put(notices, state.ended ? [] : state.notices.map((notice) => h("p", { class: "muted" }, sentence(notice))));
    forces.hidden = !state.blocks.size;
    sayProgress(bar, left, state);
    common.draw(state);
    draw(state, list, force, id);
  };
}

function draw(state, list, force, id) {
  const found = new Map([...state.blocks.values()].map((block) => [`${block.level} ${block.frequency_hz}`, block]));
  const levels = Object.keys(state.plan.levels_v);
  const wanted = levels.flatMap((level) => state.plan.frequencies_hz.map((hz) => [level, hz]));
  put(list, wanted.map(([level, hz]) => {
    const block = found.get(`${level} ${hz}`);
    const settled = block?.facts?.settled === undefined ? "" : Number(block.facts.settled) ? ", settled" : ", not settled";
    return h("tr", {}, h("th", { scope: "row" }, level), h("td", { class: "n" }, `${hz.toFixed(3)} Hz`), h("td", { class: "n" }, block?.facts?.force_n === undefined ? "–" : `${number(block.facts.force_n, 3)} N`),
      h("td", { class: block ? (block.accepted ? "good" : "bad") : "muted" }, block ? (block.accepted ? `measured${settled}` : block.reason) : "to do"),
      h("td", {}, !state.ended && block && button("Repeat", () => order(id, "repeat", { frequency_hz: hz, level }), { "aria-label": `Repeat ${hz.toFixed(3)} Hz` })));
  }));
  const lines = [...new Set([...found.values()].map((block) => block.frequency_hz))].sort((a, b) => a - b);
  if (lines.length) force.draw(levels.map((level, n) => ({ label: level, ...look(n) })), [lines, ...levels.map((level) => lines.map((hz) => found.get(`${level} ${hz}`)?.facts?.force_n ?? null))]);
}
