/** Mode shapes that move, in three dimensions: a drag or the arrow keys turn them. */

import { colour } from "./charts.js";
import { fitted, h } from "./dom.js";
import { number } from "./numbers.js";

const PERIOD_MS = 1600;
const HEIGHT = 300, EDGE = 22;
const REACH = 0.16;
/** A line of points is seen from the side at first, anything else from above. */
const BESIDE = [0.35, 0.3], ABOVE = [0.6, 0.45];
const STEP = 0.12, PER_PIXEL = 0.01;

/** One structure that moves; `look()` says what of it is drawn: [{ motion: [place][axis] of [re, im], colour }]. */
export class Moving3D {
  constructor(name, { places_m: places, lines, surfaces }, look, signal) {
    Object.assign(this, { lines, surfaces, look });
    const middle = [0, 1, 2].map((k) => (Math.max(...places.map((p) => p[k])) + Math.min(...places.map((p) => p[k]))) / 2);
    this.places = places.map((p) => p.map((value, k) => value - middle[k]));
    this.size = 2 * Math.max(...this.places.flat().map(Math.abs)) || 1;
    const flat = this.places.every(([, y, z]) => Math.abs(y) + Math.abs(z) < 1e-6 * this.size);
    [this.turn, this.tilt] = flat ? BESIDE : ABOVE;
    this.moves = !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.element = h("canvas", { class: "shape", role: "img", tabindex: "0", "aria-label": `${name}: drag, or use the arrow keys, to turn it`,
      onpointerdown: (event) => { this.held = [event.clientX, event.clientY]; this.element.setPointerCapture(event.pointerId); },
      onpointermove: (event) => { if (this.held) { this.rotate((event.clientX - this.held[0]) * PER_PIXEL, (event.clientY - this.held[1]) * PER_PIXEL); this.held = [event.clientX, event.clientY]; } },
      onpointerup: () => { this.held = null; }, onpointercancel: () => { this.held = null; }, onkeydown: (event) => this.key(event) });
    this.width = 0;
    fitted(this.element, HEIGHT, (width) => { this.width = width; }, signal);
    const frame = (now) => {
      if (signal.aborted) return;
      if (this.width) this.draw(this.moves ? now : 0);
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  rotate(turn, tilt) {
    this.turn += turn;
    this.tilt = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.tilt + tilt));
  }

  key(event) {
    const by = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, -STEP], ArrowDown: [0, STEP] }[event.key];
    if (!by) return;
    event.preventDefault();
    this.rotate(...by);
  }

  /** Parallel projection: z up, turned about it, then tilted towards the eye. */
  seen([x, y, z]) {
    const [c, s] = [Math.cos(this.turn), Math.sin(this.turn)];
    return [c * x - s * y, -(z * Math.cos(this.tilt) + (s * x + c * y) * Math.sin(this.tilt))];
  }

  draw(now) {
    const context = this.element.getContext("2d");
    const [width, height] = [this.width, HEIGHT];
    // All of it stays in sight however it is turned.
    const rest = this.places.map((p) => this.seen(p));
    const reach = REACH * this.size;
    const scale = Math.min((width / 2 - EDGE) / (Math.max(...rest.map(([x]) => Math.abs(x))) + reach), (height / 2 - EDGE) / (Math.max(...rest.map(([, y]) => Math.abs(y))) + reach));
    const at = ([x, y]) => [width / 2 + scale * x, height / 2 + scale * y];
    const path = (points, ids, close) => { context.beginPath(); ids.forEach((n, k) => context[k ? "lineTo" : "moveTo"](...points[n])); if (close) context.closePath(); };
    context.clearRect(0, 0, width, height);
    this.axes(context);
    context.lineWidth = 1;
    context.strokeStyle = colour("grid");
    const still = rest.map(at);
    for (const line of this.lines) { path(still, line); context.stroke(); }
    const angle = (2 * Math.PI * now) / PERIOD_MS;
    for (const { motion, colour: name } of this.look()) {
      const moved = this.places.map((p, n) => at(this.seen(p.map((value, k) => value + reach * (motion[n][k][0] * Math.cos(angle) - motion[n][k][1] * Math.sin(angle))))));
      context.fillStyle = context.strokeStyle = colour(name);
      context.globalAlpha = 0.15;
      for (const face of this.surfaces) { path(moved, face, true); context.fill(); }
      context.globalAlpha = 1;
      context.lineWidth = 2.5;
      for (const line of this.lines) { path(moved, line); context.stroke(); }
      for (const [x, y] of moved) { context.beginPath(); context.arc(x, y, 3.5, 0, 7); context.fill(); }
    }
  }

  axes(context) {
    context.lineWidth = 1.5;
    context.strokeStyle = context.fillStyle = colour("muted");
    context.font = "13px system-ui";
    ["x", "y", "z"].forEach((name, k) => {
      const [x, y] = this.seen([0, 1, 2].map((n) => (n === k ? 1 : 0)));
      context.beginPath();
      context.moveTo(36, HEIGHT - 36);
      context.lineTo(36 + 22 * x, HEIGHT - 36 + 22 * y);
      context.stroke();
      context.fillText(name, 33 + 30 * x, HEIGHT - 32 + 30 * y);
    });
  }
}

/** Motions [mode][place][axis] of [re, im]. */
export const motions = ({ re, im }) => re.map((mode, m) => mode.map((place, n) => place.map((value, k) => [value, im[m][n][k]])));

/** The shape of one mode, and which one it is. */
export class ShapeView {
  constructor(name, shapes, signal) {
    const each = motions(shapes.motion), id = `shape-${name}`;
    this.choice = h("select", { id }, shapes.frequency_hz.map((hz, n) => h("option", { value: n }, `${n + 1}: ${number(hz, 5)} Hz`)));
    const moving = new Moving3D(`Shape of a mode of the ${name} test`, shapes, () => [{ motion: each[Number(this.choice.value)], colour: "trace" }], signal);
    const moves = h("input", { type: "checkbox", checked: moving.moves, onchange: () => { moving.moves = moves.checked; } });
    this.element = h("div", {}, moving.element, h("p", { class: "buttons" }, h("label", { for: id }, "Mode"), this.choice, h("label", {}, moves, " moves")));
  }
}
