/** Charts by uPlot in the page's colours. */

import { h } from "./dom.js";

/** A colour of the style sheet. */
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

const DASHES = [[], [6, 3], [2, 3]];

/** The nth line's look: ten colours, then dashes. */
export const look = (n) => ({ stroke: colour(`line-${n % 10}`), width: 1.5, dash: DASHES[Math.floor(n / 10) % 3] });

const axis = (label, more) => ({
  label, stroke: colour("ink"), labelSize: 22, labelFont: "13px system-ui", font: "12px system-ui",
  grid: { stroke: colour("grid"), width: 1 }, ticks: { stroke: colour("grid"), width: 1 }, ...more,
});

const powers = (plot, _, low, high) => {
  const found = [];
  for (let exponent = Math.ceil(Math.log10(low) - 1e-9); 10 ** exponent <= high * (1 + 1e-9); exponent += 1) found.push(10 ** exponent);
  return found;
};

const power = (_, splits) => splits.map((value) => {
  if (value === null) return "";
  const exponent = Math.log10(value);
  if (Math.abs(exponent - Math.round(exponent)) > 1e-6) return "";
  return exponent >= -2 && exponent <= 3 ? String(Number(value.toPrecision(3))) : `1e${Math.round(exponent)}`;
});

/** What a chart is asked for in words: name, axes, height, whether its values are logarithmic, or its places whole numbers. */
export class Chart {
  constructor({ name, x, y, log = false, height = 260, series = [], range, sync, xRange, hooks, points = false, whole = false }) {
    this.options = { name, x, y, log, height, range, sync, xRange, hooks, points, whole };
    this.place = h("div", { class: "chart", role: "img", "aria-label": name });
    this.key = h("ul", { class: "key", "aria-label": `Lines of: ${name}` });
    this.element = h("figure", {}, h("figcaption", {}, name), this.place, this.key);
    this.watcher = new ResizeObserver(() => this.fit());
    this.watcher.observe(this.place);
    this.series = null;
    this.data = null;
    if (series.length) this.draw(series, [[], ...series.map(() => [])]);
  }

  /** Show lines: `series` are {label, ...look}, `data` is [x, y of each]. */
  draw(series, data) {
    const shape = JSON.stringify(series.map(({ label, stroke, dash }) => [label, stroke, dash]));
    this.data = data;
    if (this.plot && shape === this.shape) { this.plot.setData(data); return; }
    this.shape = shape;
    this.series = series;
    this.plot?.destroy();
    this.plot = null;
    this.fit();
    this.key.replaceChildren(...(series.length > 1 ? series.map(({ label, stroke, dash }) => h("li", {}, swatch(stroke, dash), label)) : []));
  }

  fit() {
    const width = Math.floor(this.place.clientWidth);
    if (!this.series || !width) return;
    if (this.plot) { this.plot.setSize({ width, height: this.options.height }); return; }
    const { x, y, log, height, range, sync, xRange, hooks, points, whole } = this.options;
    this.plot = new uPlot({
      width, height, legend: { show: false }, hooks,
      cursor: { drag: { x: true, y: false }, ...(sync && { sync: { key: sync } }) },
      scales: { x: { time: false, ...(xRange && { range: xRange }) }, y: { distr: log ? 3 : 1, ...(range && { range }) } },
      axes: [axis(x, { size: 34, ...(whole && { incrs: [1, 2, 5, 10, 20, 50] }) }), axis(y, { size: 58, ...(log && { values: power, splits: powers }) })],
      series: [{}, ...this.series.map((one) => ({ points: { show: points }, spanGaps: false, ...one }))],
    }, this.data, this.place);
  }

  close() {
    this.watcher.disconnect();
    this.plot?.destroy();
  }
}

function swatch(stroke, dash = []) {
  const canvas = h("canvas", { width: 22, height: 10, "aria-hidden": "true" });
  const context = canvas.getContext("2d");
  Object.assign(context, { strokeStyle: stroke, lineWidth: 3 });
  context.setLineDash(dash);
  context.moveTo(0, 5);
  context.lineTo(22, 5);
  context.stroke();
  return canvas;
}

/** Values that a logarithmic scale can show. */
export const positive = (values) => Array.from(values, (value) => (value > 0 ? value : null));
