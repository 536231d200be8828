/** The impact test: what to do now and whether the last hit was good, to be read from two metres. */

import { get } from "../api.js";
import { BeamDrawing } from "../beam.js";
import { Chart, colour, look } from "../charts.js";
import { button, h, panel, put, say, sentence, show as showError } from "../dom.js";
import { GrowingFrf } from "../growing-frf.js";
import { lab } from "../lab.js";
import { ModesSoFar } from "../modes-so-far.js";
import { duration, number, percent, quantity } from "../numbers.js";
import { play, sound } from "../sound.js";
import { LiveStrips, drawStrip, stripCanvas, throttled } from "../strips.js";
import { order, runButtons, showTest } from "../test-view.js";

const KEYS = { a: "accept", pagedown: "accept", u: "undo", pageup: "undo", p: "pause" };
const SOUNDS = { ready: "ready", good: "good", rejected: "rejected", early: "early" };

const form = {
  name: "ImpactPlan", kind: "impact", first: ["points", "hits", "rate_hz"],
  start: (description) => ({ points: description.points.map(({ id }) => id).reverse() }),
};

export const show = (view, signal, [like]) => showTest(view, signal, { like, test: "impact", title: "Impact test", form, parts });

/** The words of the prompt: [large, small, mood]. */
function prompt(state) {
  const where = state.point === null ? "" : `point ${state.point}`;
  const hit = state.of ? `hit ${state.hit} of ${state.of}` : "";
  switch (state.phase) {
    case "ready": return [`Strike ${where}`, hit, "ready"];
    case "waiting": return ["Wait", resting(state.rest), "waiting"];
    case "decide": return ["Does it count?", "A: accept the hit. U: reject the hit.", "early"];
    case "paused": return ["Paused", "Go on with P", "waiting"];
    case "done": return ["Done", "The plan is completely recorded.", "good"];
    case "failed": return ["Ended early", failure(state), "rejected"];
    case "aborted": return ["Stopped", sentence(state.reason || "the run was aborted"), "rejected"];
    case "good": return ["Wait", "The next hit is being prepared.", "waiting"];
    default: return ["Wait", ["rejected", "early"].includes(state.phase) ? "Repeat the hit." : "The bench is being prepared.", "waiting"];
  }
}

const failure = ({ failed, reason }) => (failed ? `${sentence(failed.what)} ${failed.remedy ? sentence(failed.remedy) : ""}` : sentence(reason || "the run has failed"));

function resting({ residual_ratio: ratio, allowed, residual_hz: hz, remaining_s: left }) {
  if (ratio === null) return "The beam comes to rest.";
  return `Still moving ${percent(ratio, 2)} at ${number(hz, 3)} Hz, ${percent(allowed, 2)} allowed${left === null ? "" : `, about ${duration(left)}`}.`;
}

/** The words of the last hit. */
function verdict({ last }) {
  if (!last) return ["–", "no hit yet", ""];
  const force = last.facts?.peak_n === undefined ? "" : `${number(last.facts.peak_n, 3)} N`;
  if (last.verdict === "good") return ["Good", force, "good"];
  if (last.verdict === "early") return ["Too early", sentence(last.reason), "early"];
  if (last.verdict === "dropped") return ["Undone", sentence(last.reason), "early"];
  return ["Rejected", sentence(last.reason || "the hit does not count"), "rejected"];
}

function parts(place, signal, id) {
  const [now, small] = [h("p", { class: "large" }), h("p", { class: "under" })];
  const prompting = h("section", { class: "prompt", "aria-label": "What to do now", "aria-live": "assertive" }, now, small);
  const [judged, why] = [h("p", { class: "large" }), h("p", { class: "under" })];
  const last = h("section", { class: "prompt", "aria-label": "The last hit", "aria-live": "polite" }, h("h2", {}, "Last hit"), judged, why);
  const togo = h("p", { class: "togo" });
  const beam = new BeamDrawing(lab.description);
  const common = runButtons(id);
  let state = null;
  const acts = {
    accept: () => order(id, "accept", { n: meantBlock(state, false) }),
    undo: () => order(id, "drop", { n: meantBlock(state, true), reason: "undone by the operator" }),
    pause: () => common.pause(),
  };
  const accept = button("", acts.accept, { "aria-keyshortcuts": "a" });
  const undo = button("", acts.undo, { "aria-keyshortcuts": "u" });
  const loud = h("input", { type: "checkbox", id: "sound", checked: sound.on, onchange: ({ target }) => { sound.on = target.checked; } });
  const pulse = new Pulse(id, signal);
  const modes = new ModesSoFar(id, signal, () => count());
  put(place, h("div", { class: "pair" }, prompting, last),
    h("section", { class: "panel", "aria-label": "Beam" }, togo, beam.element, h("p", { class: "buttons" }, accept, undo, common.elements, h("label", {}, loud, " Sound"))),
    h("div", { class: "pair" }, scope(signal), pulse.element), modes.element, new GrowingFrf(id, signal).element);
  addEventListener("keydown", (event) => {
    const act = KEYS[event.key.toLowerCase()];
    if (!act || event.repeat || event.ctrlKey || event.metaKey || event.altKey || ["INPUT", "SELECT", "TEXTAREA"].includes(event.target.tagName) && event.target.type !== "checkbox") return;
    event.preventDefault();
    if (state && !state.ended) acts[act]().catch(showError);
  }, { signal });

  function count() {
    const good = Object.values(state.counts).reduce((sum, one) => sum + one, 0);
    const total = state.plan.points.length * state.plan.hits;
    const left = state.ended ? "" : `, ${Math.max(0, total - good)} to go`;
    say(togo, `${good} of ${total} good hits${left}${modes.enough ? ". Enough: every mode is known as well as the plan asks" : ""}`);
  }

  return (next, event) => {
    state = next;
    const [large, words, mood] = prompt(state);
    prompting.dataset.mood = mood;
    prompting.dataset.asked = state.phase === "decide" ? state.asked : "";
    say(now, large);
    say(small, words);
    const [said, reason, color] = verdict(state);
    last.dataset.mood = color;
    say(judged, said);
    say(why, reason);
    beam.show(state.phase === "ready" || state.phase === "waiting" ? state.point : null, state.counts, state.plan.hits);
    count();
    say(accept, state.phase === "decide" ? "It counts (A)" : "Accept the rejected hit (A)");
    say(undo, state.phase === "decide" ? "Reject the hit (U)" : "Undo the last good hit (U)");
    accept.hidden = state.ended;
    undo.hidden = state.ended;
    accept.disabled = meantBlock(state, false) === undefined || !["rejected", "decide", "ready", "waiting"].includes(state.phase);
    undo.disabled = meantBlock(state, true) === undefined;
    common.draw(state);
    if (event && SOUNDS[state.phase] && ["hit_requested", "block", "hit_rejected", "hit_too_early"].includes(event.kind)) play(SOUNDS[state.phase]);
    const n = Math.max(-1, ...state.blocks.keys());
    if (n >= 0) pulse.look(n);
    modes.look(state);
  };
}

/** Number of the block that the operator is asked about; where nothing is asked, of the newest that the key can change. */
const meantBlock = (state, accepted) => (state?.phase === "decide" ? state.asked : lastBlock(state, accepted));

/** Number of the newest block that counts, or that does not; a hit further back is not what the key means. */
function lastBlock(state, accepted) {
  const blocks = [...(state?.blocks.values() ?? [])];
  if (!accepted) return blocks.at(-1)?.accepted === false ? blocks.at(-1).n : undefined;
  return blocks.findLast((block) => block.accepted)?.n;
}

function scope(signal) {
  const { channels } = lab.description;
  const canvases = new Map(channels.map(({ name }) => [name, stripCanvas(name)]));
  const values = new Map(channels.map(({ name }) => [name, h("span", { class: "n" })]));
  const strips = new LiveStrips(lab.description, lab.rig.id, throttled(() => {
    for (const [name, strip] of strips.strips) {
      const { peak, overload } = strip.level;
      drawStrip(canvases.get(name), strip, { ink: colour(overload ? "bad" : "trace"), line: colour("grid") });
      say(values.get(name), quantity(peak, strip.unit));
    }
  }, signal), signal);
  strips.test = "impact";
  return panel("Scope", h("ul", { class: "scope" }, channels.map(({ name }) => h("li", {}, h("span", {}, name), canvases.get(name), values.get(name)))));
}

/** The force of the last hit, about its trigger, and its spectrum. */
class Pulse {
  constructor(run, signal) {
    Object.assign(this, { run, shown: -1, busy: false, signal });
    this.time = new Chart({ name: "Force of the last hit", x: "Time after the trigger [ms]", y: "Force [N]", height: 190 });
    this.spectrum = new Chart({ name: "Its spectrum", x: "Frequency [Hz]", y: "Force [N s]", log: true, height: 190 });
    this.element = panel("Force pulse", this.time.element, this.spectrum.element);
    signal.addEventListener("abort", () => { this.time.close(); this.spectrum.close(); });
  }

  async look(n) {
    this.wanted = n;
    if (this.busy) return;
    this.busy = true;
    try {
      while (this.shown !== this.wanted && !this.signal.aborted) {
        const number_ = this.wanted;
        this.draw(await get(`runs/${this.run}/blocks/${number_}/force`));
        this.shown = number_;
      }
    } catch (error) {
      showError(error);
      this.shown = this.wanted;
    } finally { this.busy = false; }
  }

  draw({ rate_hz: rate, force_n: force, spectrum_hz: lines, spectrum_n_s: spectrum }) {
    const top = force.reduce((best, value, i) => (Math.abs(value) > Math.abs(force[best]) ? i : best), 0);
    const trigger = force.findIndex((value) => Math.abs(value) > Math.abs(force[top]) * 0.05);
    const from = Math.max(0, trigger - Math.round(0.005 * rate));
    const piece = force.slice(from, from + Math.round(0.03 * rate));
    this.time.draw([{ label: "force", ...look(0) }], [piece.map((_, i) => ((from + i - trigger) / rate) * 1000), piece]);
    this.spectrum.draw([{ label: "force", ...look(0) }], [lines, spectrum.map((value) => (value > 0 ? value : null))]);
  }
}
