/** The stabilisation diagram, to choose poles on. */

import { colour } from "./charts.js";
import { button, fitted, h, panel, put } from "./dom.js";
import { number } from "./numbers.js";

const HEIGHT = 320;
/** Width of a frequency on the axis, with room beside it. */
const TICK_PX = 60;
const NEAR_PX = 14;

/** Poles by order, over the mode indicator; a click or the list below chooses poles for a model by hand. */
export class Stabilisation {
  constructor(name, diagram, model, identify, signal) {
    Object.assign(this, { diagram, chosen: new Set(), signal });
    this.low = Math.min(...diagram.line_hz);
    this.high = Math.max(...diagram.line_hz);
    this.orders = [Math.min(...diagram.order), Math.max(...diagram.order)];
    this.canvas = h("canvas", { class: "diagram", role: "img", "aria-label": `Stabilisation diagram of the ${name} test; its stable poles are in the list below`, onclick: (event) => this.click(event) });
    this.list = h("p", { class: "buttons", role: "group", "aria-label": "Poles that hold" });
    this.picked = h("p", { role: "status" });
    this.held = diagram.held_hz.map((hz) => Number(hz));
    this.element = panel(`Stabilisation diagram, ${name} test`, this.canvas, h("p", { class: "muted" }, "Filled: stable; open: stable in frequency; small: new. The line is the mode indicator (CMIF)."), this.list, this.picked,
      h("p", { class: "buttons" }, button("Identify with these poles only", async () => {
        if (!this.chosen.size) throw new Error("Choose at least one pole.");
        await identify({ pick_hz: [...this.chosen].sort((a, b) => a - b), ...(model.test && { test: model.test }) });
      }), button("Identify automatically", () => identify())));
    // A pole of the model is named as the table above names it.
    this.refined = new Map(model.frequency_hz.map((hz) => [this.nearestHeld(hz), hz]));
    for (const hz of this.refined.keys()) this.chosen.add(hz);
    this.width = 0;
    fitted(this.canvas, HEIGHT, (width) => { this.width = width; this.draw(); }, signal);
    this.drawList();
  }

  nearestHeld(hz) { return this.held.reduce((best, one) => (Math.abs(one - hz) < Math.abs(best - hz) ? one : best), this.held[0] ?? hz); }

  x(hz) { return 44 + ((hz - this.low) / (this.high - this.low)) * (this.width - 60); }

  y(order) { return HEIGHT - 34 - ((order - this.orders[0]) / (this.orders[1] - this.orders[0] || 1)) * (HEIGHT - 56); }

  click({ offsetX, offsetY }) {
    const { frequency_hz: hz, order } = this.diagram;
    let best = NEAR_PX;
    let found = null;
    hz.forEach((one, n) => {
      const away = Math.hypot(this.x(one) - offsetX, this.y(order[n]) - offsetY);
      if (away < best) { best = away; found = one; }
    });
    if (found === null) return;
    const held = this.nearestHeld(found);
    this.toggle(Math.abs(held - found) < 0.01 * found ? held : found);
  }

  toggle(hz) {
    if (!this.chosen.delete(hz)) this.chosen.add(hz);
    this.draw();
    this.drawList();
  }

  draw() {
    const context = this.canvas.getContext("2d");
    const { frequency_hz: hz, order, standing, line_hz: lines, cmif } = this.diagram;
    context.clearRect(0, 0, this.width, HEIGHT);
    context.font = "13px system-ui";
    context.fillStyle = colour("muted");
    context.fillText("Order", 4, 13);
    context.fillText("Hz", this.width - 24, HEIGHT - 26);
    const ticks = Math.max(2, Math.min(10, Math.floor(this.width / TICK_PX)));
    const least = (this.high - this.low) / ticks;
    const ten = 10 ** Math.floor(Math.log10(least));
    const step = ten * [1, 2, 5, 10].find((one) => one * ten >= least);
    for (let at = Math.ceil(this.low / step) * step; at <= this.high; at += step) context.fillText(String(Number(at.toPrecision(4))), this.x(at) - 12, HEIGHT - 10);
    for (const one of new Set([this.orders[0], Math.round((this.orders[0] + this.orders[1]) / 2), this.orders[1]])) context.fillText(String(one), 14, this.y(one) + (one === this.orders[1] ? 12 : 5));
    this.drawIndicator(context, lines, cmif[0]);
    context.strokeStyle = colour("accent");
    context.lineWidth = 2;
    for (const one of this.chosen) { context.beginPath(); context.moveTo(this.x(one), 18); context.lineTo(this.x(one), HEIGHT - 30); context.stroke(); }
    hz.forEach((one, n) => {
      if (one < this.low || one > this.high) return;
      context.beginPath();
      context.arc(this.x(one), this.y(order[n]), standing[n] ? 4 : 1.8, 0, 7);
      context.fillStyle = context.strokeStyle = colour(standing[n] === 2 ? "good" : standing[n] === 1 ? "line-1" : "muted");
      context.lineWidth = 1.5;
      if (standing[n] === 1) context.stroke(); else context.fill();
    });
  }

  drawIndicator(context, lines, values) {
    const logs = values.map((value) => Math.log10(Math.max(value ?? 0, 1e-30)));
    const [low, high] = [Math.min(...logs), Math.max(...logs)];
    context.strokeStyle = colour("trace");
    context.lineWidth = 1.2;
    context.beginPath();
    lines.forEach((hz, n) => context.lineTo(this.x(hz), HEIGHT - 34 - ((logs[n] - low) / (high - low || 1)) * (HEIGHT - 56)));
    context.stroke();
  }

  drawList() {
    const all = [...new Set([...this.held, ...this.chosen])].sort((a, b) => a - b);
    const focused = [...this.list.children].indexOf(document.activeElement);
    put(this.list, all.map((hz) => h("button", { type: "button", "aria-pressed": String(this.chosen.has(hz)), onclick: () => this.toggle(hz) }, `${number(this.refined.get(hz) ?? hz, 5)} Hz`)));
    this.list.children[focused]?.focus();
    put(this.picked, `${this.chosen.size} chosen. Those of the model are listed as refined, other poles that hold as the estimator found them.`);
  }
}
