/** What tests with a shaker have in common: the words of their states, and the force beside its limit. */

import { colour } from "./charts.js";
import { h, put, say, sentence } from "./dom.js";
import { lab } from "./lab.js";
import { duration, number, quantity } from "./numbers.js";
import { LiveStrips, drawStrip, stripCanvas, throttled } from "./strips.js";

const WORDS = { created: "Preparing", arming: "Preparing", armed: "Ready", acquiring: "Measuring", paused: "Paused", processing: "Finishing", stopping: "Bringing the output to 0 V", done: "Done", failed: "Ended early", aborted: "Stopped" };
const MOODS = { acquiring: "ready", done: "good", failed: "rejected", aborted: "rejected", paused: "waiting" };

/** What is being done in large letters, and why it ended beneath; `under(done, total)` says what else is beneath while it measures. */
export function sayState([large, small], prompt, state, under) {
  const { done = 0, total = 0, what = "" } = state.progress ?? {};
  prompt.dataset.mood = MOODS[state.state] ?? "waiting";
  say(large, state.state === "acquiring" && what ? what.replace(/^level /, "") : WORDS[state.state] ?? state.state);
  say(small, state.failed ? `${sentence(state.failed.what)} ${sentence(state.failed.remedy || "look at the bench")}` : state.ended ? sentence(state.reason || "the plan is completely recorded") : state.state === "acquiring" && total ? under(done, total) : "");
}

/** How far it is, and about how long it still takes. */
export function sayProgress(bar, left, state) {
  const { done = 0, total = 0 } = state.progress ?? {};
  bar.max = Math.max(1, total);
  bar.value = done;
  const { remaining } = state;
  say(left, total ? `${done} of ${total} measured${Number.isFinite(remaining) ? `, about ${duration(remaining)} left` : ""}` : "No measurement yet");
}

/** The force as it is now, beside its limit. */
export function watchDrive(place, limits, signal, test) {
  const others = (lab.description.shakers ?? []).map(({ force }) => force);
  const { name } = lab.description.channels.find(({ quantity, name }) => quantity === "force" && !others.includes(name));
  const response = lab.description.channels.find(({ quantity, point }) => quantity !== "force" && point === lab.description.shaker_point) ?? lab.description.channels.find(({ quantity }) => quantity !== "force");
  const rows = [[name, limits?.force_n, "N"], [response.name, limits?.acceleration_m_s2, "m/s²"]].map(([channel, limit, unit]) => ({ channel, limit, unit, canvas: stripCanvas(channel), value: h("span", { class: "n" }, "–") }));
  put(place, place.firstChild, h("ul", { class: "scope" }, rows.map(({ channel, canvas, value }) => h("li", {}, h("span", {}, channel), canvas, value))),
    h("p", { class: "muted" }, limits ? `Limits: ${number(limits.drive_v, 3)} V drive, ${number(limits.force_n, 3)} N, ${number(limits.acceleration_m_s2, 3)} m/s². Above a limit the output goes to 0 V.` : "The rig file has no limits: driving is not possible."));
  const strips = new LiveStrips(lab.description, lab.rig.id, throttled(() => {
    for (const { channel, limit, unit, canvas, value } of rows) {
      const strip = strips.strips.get(channel);
      if (!strip) continue;
      const { peak } = strip.level;
      drawStrip(canvas, strip, { ink: colour(limit && peak > 0.8 * limit ? "bad" : "trace"), line: colour("grid") });
      say(value, quantity(peak, unit));
    }
  }, signal), signal);
  strips.test = test;
}
