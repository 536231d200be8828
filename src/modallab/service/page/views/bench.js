/** The bench: every channel with its live level, who may command it, and whether it may move. */

import { colour } from "../charts.js";
import { button, h, panel, put, say, table } from "../dom.js";
import { command, lab, lease, release, watch } from "../lab.js";
import { duration, number, unit } from "../numbers.js";
import { LiveStrips, drawStrip, sensitivity, stripCanvas, throttled } from "../strips.js";

/** What the channel can show at most, in its unit. */
const fullScale = (channel, converter, test) => (channel.range_v ?? converter?.range_v ?? 10) / sensitivity(channel, test);

export function show(view, signal) {
  const description = lab.description;
  const rows = new Map(description.channels.map((channel) => [channel.name, row(channel, description.converter)]));
  const condition = panel("Condition");
  const live = h("p", { class: "muted", "aria-live": "polite" });
  put(view, h("h1", {}, "Bench"), condition, panel("Channels", live,
    table("Channels with their live levels", [["Channel"], ["Point", "n"], ["Unit"], ["Last 6 s", "wide"], ["Level of full scale"], ["Peak", "n"], ["Noise, rms", "n"], ["Bias", "n"], ["Full scale", "n"], ["State"], ["Calibrated"]],
      [...rows.values()].map(({ cells }) => cells))));
  watch(() => put(condition, condition.firstChild, state()), signal);
  const strips = new LiveStrips(lab.description, lab.rig.id, throttled(() => draw(), signal), signal);
  const timer = setInterval(() => sayLive(live, strips), 1000);
  signal.addEventListener("abort", () => clearInterval(timer));
  sayLive(live, strips);

  function draw() {
    strips.test = lab.test;
    const ink = { ink: colour("trace"), line: colour("grid") };
    for (const strip of strips.strips.values()) rows.get(strip.name)?.draw(strip, ink, lab.test);
  }
}

function sayLive(element, strips) {
  if (strips.fresh) say(element, `Live at ${number(strips.about.rate_hz, 4)} Hz${strips.about.run ? ` from run ${strips.about.run}` : ", nothing is recorded"}.`);
  else say(element, "There are no live samples now; a run sends live samples.");
}

function row(channel, converter) {
  const canvas = stripCanvas(channel.name);
  const meter = h("meter", { min: 0, max: 1, low: 0.6, high: 0.9, optimum: 0.3, value: 0, "aria-label": `Level of ${channel.name}` });
  const [peak, noise, bias] = [h("span"), h("span"), h("span")];
  const lamp = h("span", { class: "lamp" }, "no signal");
  const full = h("span");
  const calibrated = channel.calibrated_on ?? "not stated";
  function scale(test) { say(full, number(fullScale(channel, converter, test), 3)); }
  function draw(strip, ink, test) {
    const { peak: most, mean, spread, overload } = strip.level;
    drawStrip(canvas, strip, ink);
    meter.value = Math.min(1, most / fullScale(channel, converter, test));
    say(peak, number(most, 3));
    say(noise, `± ${number(spread, 2)}`);
    say(bias, number(mean, 2));
    scale(test);
    lamp.className = `lamp ${overload ? "bad" : "good"}`;
    say(lamp, overload ? "overload" : "in range");
  }
  const cells = [h("span", {}, channel.name, h("small", {}, ` ${channel.quantity} ${channel.direction}`)), channel.point ?? "–", unit(channel.unit), canvas, meter, peak, noise, bias, full, lamp, `${calibrated}${channel.serial ? `, ${channel.serial}` : ""}`];
  scale("impact");
  return { cells, draw };
}

function state() {
  const { rig } = lab;
  const facts = h("dl", { class: "facts" },
    fact("Rig", rig.name), fact("Address", rig.bench, "", "broad"),
    fact("State", rig.trip ? "stopped in an emergency" : WORDS[rig.state] ?? rig.state, rig.trip || rig.state === "unavailable" ? "bad" : "good"),
    fact("Run", rig.run ?? "none"),
    fact("Drive", rig.can_drive ? "has an output for the shaker" : "reads only"),
    fact("Lease", rig.lease ? `${rig.lease.operator}, ${duration(rig.lease.remaining_s)} left${lab.lease ? " (this page)" : ""}` : "nobody holds it"));
  return [facts, rig.error && h("p", { class: "bad" }, rig.error), rig.trip && tripped(rig.trip), h("p", { class: "buttons" },
    !lab.lease && button(rig.lease ? "Take over" : "Take the lease", () => lease({ takeOver: Boolean(rig.lease) })),
    lab.lease && button("Release the lease", release))];
}

const WORDS = { starting: "its bench is being opened", idle: "ready", running: "a run is on", unavailable: "cannot be used" };

const fact = (name, value, mood, size) => h("div", { class: size }, h("dt", {}, name), h("dd", { class: mood }, value));

function tripped({ cause, reason }) {
  return h("div", { class: "alarm", role: "status" }, h("p", {}, h("strong", {}, `Stopped: ${cause} `), reason, ". Check the bench before it may move again."),
    button("Bench checked: reset", () => command(`rigs/${lab.rig.id}/reset`, { reason: "reset on the operator's page" })));
}
