/** The broadband test: random, burst random, pseudo-random or chirp; how far it is, its blocks, and the FRF as it grows. */

import { h, panel, put, sentence } from "../dom.js";
import { sayProgress, sayState, watchDrive } from "../driven.js";
import { GrowingFrf } from "../growing-frf.js";
import { lab } from "../lab.js";
import { number } from "../numbers.js";
import { runButtons, showTest } from "../test-view.js";

const SIGNALS = ["random", "burst-random", "pseudo-random", "chirp"];
const form = { name: "BroadbandPlan", kind: "broadband", first: ["signal", "band_hz", "levels_v", "blocks", "settle_s", "wait_s"], start: () => ({ levels_v: { low: 0.5 } }) };

export const show = (view, signal, [like]) => showTest(view, signal, { like, test: SIGNALS, title: "Broadband test", form, parts });

function parts(place, signal, id) {
  const said = [h("p", { class: "large" }), h("p", { class: "under" })];
  const prompt = h("section", { class: "prompt", "aria-label": "State of the test", "aria-live": "polite" }, said);
  const bar = h("progress", { max: 1, value: 0, "aria-label": "Progress of the test" });
  const left = h("p", { class: "under" });
  const common = runButtons(id);
  const drive = panel("Drive");
  const list = h("tbody");
  const notices = h("div");
  const blocks = h("div", { class: "scroll tall", tabindex: "0", role: "region", "aria-label": "Blocks so far" }, h("table", {}, h("thead", {}, h("tr", {}, ["Block", "Level", "Wave", "Drive, rms [V]", "State"].map((head, n) => h("th", { scope: "col", class: n === 2 || n === 3 ? "n" : null }, head)))), list));
  put(place, h("div", { class: "pair" }, prompt, h("section", { class: "prompt", "aria-label": "Progress" }, h("h2", {}, "Progress"), left, bar, h("p", { class: "buttons" }, common.elements), notices)),
    new GrowingFrf(id, signal).element,
    h("div", { class: "pair" }, h("section", { class: "panel", "aria-label": "Blocks" }, h("h2", {}, "Blocks"), blocks), drive));
  watchDrive(drive, lab.description.limits, signal, "random");

  return (state) => {
    sayState(said, prompt, state, (done, total) => `block ${Math.min(done + 1, total)} of ${total}`);
    put(notices, state.ended ? [] : state.notices.map((notice) => h("p", { class: "muted" }, sentence(notice))));
    sayProgress(bar, left, state);
    common.draw(state);
    put(list, [...state.blocks.values()].map((block) => h("tr", {}, h("th", { scope: "row" }, String(block.n)), h("td", {}, block.level ?? "–"), h("td", { class: "n" }, number(block.facts?.wave, 1)), h("td", { class: "n" }, number(block.facts?.drive_rms_v, 3)),
      h("td", { class: block.accepted ? "good" : "bad" }, block.accepted ? "measured" : block.reason))));
  };
}
