/** A mode shape that moves. */

import { colour } from "./charts.js";
import { h, panel } from "./dom.js";
import { number } from "./numbers.js";

const PERIOD_MS = 1600;
const SIZE = [620, 170];

/** The shape of one mode over the beam, and which one it is. */
export class ShapeView {
  constructor(name, model, description, signal) {
    this.places = model.output_points.map((point) => description.points.find(({ id }) => id === point)?.x_m ?? null);
    this.length = description.beam?.length_m ?? Math.max(...this.places);
    this.shapes = this.read(model);
    this.canvas = h("canvas", { class: "shape", width: SIZE[0], height: SIZE[1], role: "img", "aria-label": `Shape of a mode of the ${name} test` });
    const id = `shape-${name}`;
    this.choice = h("select", { id }, model.frequency_hz.map((hz, n) => h("option", { value: n }, `${n + 1}: ${number(hz, 5)} Hz`)));
    this.moving = h("input", { type: "checkbox", id: `${id}-moves`, checked: !matchMedia("(prefers-reduced-motion: reduce)").matches });
    this.element = panel(`Shapes, ${name} test`, this.shapes ? this.canvas : h("p", {}, model.shapes_unavailable),
      h("p", { class: "buttons" }, h("label", { for: id }, "Mode"), this.choice, h("label", {}, this.moving, " moves")));
    const frame = (now) => {
      if (signal.aborted) return;
      this.draw(this.moving.checked ? now : 0);
      requestAnimationFrame(frame);
    };
    if (this.shapes) requestAnimationFrame(frame);
  }

  /** Shapes as [re, im] by output; modal constants stand in for them where there is no driving point. */
  read(model) {
    if (model.shapes) return model.shapes.re.map((row, m) => row.map((re, k) => [re, model.shapes.im[m][k]]));
    return model.modal_constants.re.map((rows, m) => rows.map((row, k) => [row[0], model.modal_constants.im[m][k][0]]));
  }

  draw(now) {
    const context = this.canvas.getContext("2d");
    const shape = this.shapes[Number(this.choice.value)];
    const most = Math.max(...shape.map(([re, im]) => Math.hypot(re, im))) || 1;
    const angle = (2 * Math.PI * now) / PERIOD_MS;
    const points = this.places.map((place, k) => [place, (shape[k][0] * Math.cos(angle) - shape[k][1] * Math.sin(angle)) / most]).filter(([place]) => place !== null).sort((a, b) => a[0] - b[0]);
    const [width, height] = SIZE;
    const x = (place) => 24 + (place / this.length) * (width - 48);
    const y = (value) => height / 2 - value * (height / 2 - 18);
    context.clearRect(0, 0, width, height);
    context.lineWidth = 1;
    context.strokeStyle = colour("grid");
    context.beginPath();
    context.moveTo(x(0), y(0));
    context.lineTo(x(this.length), y(0));
    context.stroke();
    context.strokeStyle = colour("muted");
    context.lineWidth = 3;
    context.beginPath();
    context.moveTo(x(0), y(-0.5));
    context.lineTo(x(0), y(0.5));
    context.stroke();
    context.strokeStyle = colour("trace");
    context.beginPath();
    context.moveTo(x(0), y(0));
    for (const [place, value] of points) context.lineTo(x(place), y(value));
    context.stroke();
    context.fillStyle = colour("accent");
    for (const [place, value] of points) { context.beginPath(); context.arc(x(place), y(value), 4.5, 0, 7); context.fill(); }
  }
}
