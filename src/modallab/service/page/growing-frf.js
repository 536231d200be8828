/** FRFs and coherence of a run, growing with every block. */

import { Chart, look, positive } from "./charts.js";
import { h } from "./dom.js";
import { follow } from "./live.js";
import { unit } from "./numbers.js";

const HIGHEST_HZ = 800;

const axisOf = (axis) => (Array.isArray(axis) ? axis : Array.from({ length: axis.count }, (_, n) => axis.first + n * axis.step));

/** A part of a view: mobility at all outputs for one input point, and the coherence below it. */
export class GrowingFrf {
  constructor(run, signal, { points = false } = {}) {
    this.found = new Map();
    this.point = null;
    this.amplitude = new Chart({ name: "Mobility", x: "Frequency [Hz]", y: "Mobility [m/(N s)]", log: true, height: 300, sync: run, points });
    this.coherence = new Chart({ name: "Coherence", x: "Frequency [Hz]", y: "Coherence [1]", height: 150, range: [0, 1.02], sync: run });
    this.choice = h("select", { id: "input-point", onchange: () => { this.point = this.choice.value; this.chosen = true; this.draw(); } });
    this.averages = h("span", { class: "muted" });
    this.none = h("p", { class: "muted" }, "There is no FRF before the first good block.");
    this.shown = h("div", { hidden: true }, h("p", { class: "buttons" }, h("label", { for: "input-point" }, "Driven at point"), this.choice, this.averages), this.amplitude.element, this.coherence.element);
    this.element = h("section", { class: "panel wide", "aria-label": "FRFs so far" }, h("h2", {}, "FRFs so far"), this.none, this.shown);
    follow(`runs/${encodeURIComponent(run)}/frf/live?high_hz=${HIGHEST_HZ}`, (about, values) => this.take(about, values), signal);
    signal.addEventListener("abort", () => { this.amplitude.close(); this.coherence.close(); });
  }

  take(about, values) {
    const key = String(about.input_point ?? "unknown");
    if (!this.found.has(key)) this.choice.append(h("option", { value: key }, key));
    this.found.set(key, { about, values });
    if (!this.chosen) { this.point = key; this.choice.value = key; }
    this.draw();
  }

  draw() {
    const found = this.found.get(this.point);
    if (!found) return;
    const { about, values } = found;
    this.none.hidden = true;
    this.shown.hidden = false;
    const [, outputs, lines] = about.shape;
    const x = axisOf(about.frequency_hz);
    const part = (kind, output, value) => Array.from({ length: lines }, (_, n) => value(2 * ((kind * outputs + output) * lines + n)));
    const series = about.outputs.map((name, n) => ({ label: `${name}${about.output_points[n] ? ` at ${about.output_points[n]}` : ""}`, ...look(n) }));
    this.averages.textContent = `${about.averages} ${about.averages === 1 ? "average" : "averages"}, ${unit(about.unit)}`;
    this.amplitude.draw(series, [x, ...series.map((_, output) => positive(part(0, output, (at) => Math.hypot(values[at], values[at + 1]))))]);
    this.coherence.element.hidden = !about.coherence || about.averages < 2;
    if (!this.coherence.element.hidden) this.coherence.draw(series, [x, ...series.map((_, output) => part(1, output, (at) => values[at]))]);
    this.element.dataset.points = [...this.found.keys()].join(" ");
    this.element.dataset.averages = about.averages;
  }
}
