/** Live strips: the last seconds of every channel, drawn from extremes, one small picture a channel. */

import { h } from "./dom.js";
import { follow } from "./live.js";
import { addSender } from "./stop.js";

export const COLUMNS_PER_S = 50;
export const SHOWN_S = 6;
const COLUMNS = COLUMNS_PER_S * SHOWN_S;
const FADE_MS = 1500;

/** By what a live value is divided to be in the channel's unit: live values of a device are volts. */
export function sensitivity(channel, test, symbol) {
  if (symbol !== undefined && symbol !== "V") return 1;
  const stated = channel.sensitivity_v_per_unit ?? 1;
  return Math.abs(typeof stated === "number" ? stated : stated[test] ?? stated.sine ?? Object.values(stated)[0]);
}

/** One channel: least and largest value of each column, the newest last. */
class Strip {
  constructor(name, unit) {
    Object.assign(this, { name, unit, factor: 1, low: new Float32Array(COLUMNS), high: new Float32Array(COLUMNS), count: 0, overloadAt: -Infinity });
  }

  add(low, high) {
    const n = Math.min(low.length, COLUMNS);
    for (const [kept, added] of [[this.low, low], [this.high, high]]) {
      kept.copyWithin(0, n);
      kept.set(added.subarray(added.length - n), COLUMNS - n);
    }
    this.count = Math.min(COLUMNS, this.count + n);
  }

  /** Peak and mean of the last second, and half of what it moves about by. */
  get level() {
    const from = COLUMNS - Math.min(this.count, COLUMNS_PER_S);
    let peak = 0, sum = 0, spread = 0;
    for (let i = from; i < COLUMNS; i += 1) {
      peak = Math.max(peak, Math.abs(this.low[i]), Math.abs(this.high[i]));
      sum += (this.low[i] + this.high[i]) / 2;
      spread += (this.high[i] - this.low[i]) / 2;
    }
    const n = COLUMNS - from || 1;
    const by = this.factor;
    return { peak: peak / by, mean: sum / n / by, spread: spread / n / by, overload: performance.now() - this.overloadAt < FADE_MS };
  }
}

/** The channels of a rig as they come; `listener` is called after each message. */
export class LiveStrips {
  constructor(description, rig, listener, signal) {
    this.channels = new Map(description.channels.map((channel) => [channel.name, channel]));
    this.strips = new Map();
    this.about = null;
    this.heardAt = -Infinity;
    const send = follow(`live/envelope?rig=${encodeURIComponent(rig)}&columns_per_s=${COLUMNS_PER_S}&idle=true`, (about, values) => {
      this.take(about, values);
      listener();
    }, signal);
    addSender(send, signal);
  }

  take(about, values) {
    const columns = about.shape.at(-1);
    this.about = about;
    this.heardAt = performance.now();
    about.channels.forEach((name, row) => {
      const channel = this.channels.get(name);
      if (!channel) return;
      if (!this.strips.has(name)) this.strips.set(name, new Strip(name, channel.unit));
      const strip = this.strips.get(name);
      strip.factor = sensitivity(channel, this.test, about.units[row]);
      const at = 2 * row * columns;
      strip.add(values.subarray(at, at + columns), values.subarray(at + columns, at + 2 * columns));
      if (about.overload?.[name]?.length) strip.overloadAt = performance.now();
    });
  }

  get fresh() { return performance.now() - this.heardAt < FADE_MS; }
}

/** A picture of one strip. */
export const stripCanvas = (name) => h("canvas", { class: "strip", role: "img", "aria-label": `Last ${SHOWN_S} seconds of ${name}`, width: COLUMNS, height: 40 });

/** Draw a strip; the scale grows with what was seen, and `marks` are values with a line of their own. */
export function drawStrip(canvas, strip, colour, marks = []) {
  const context = canvas.getContext("2d");
  const { width, height } = canvas;
  let most = 1e-12;
  for (let i = COLUMNS - strip.count; i < COLUMNS; i += 1) most = Math.max(most, Math.abs(strip.low[i]), Math.abs(strip.high[i]));
  const y = (value) => height / 2 - (value / most) * (height / 2 - 2);
  context.clearRect(0, 0, width, height);
  context.strokeStyle = colour.line;
  context.beginPath();
  for (const value of [0, ...marks.filter((mark) => mark < most)]) { context.moveTo(0, y(value)); context.lineTo(width, y(value)); }
  context.stroke();
  context.fillStyle = colour.ink;
  for (let i = COLUMNS - strip.count; i < COLUMNS; i += 1) {
    const top = y(strip.high[i]);
    context.fillRect(i, top, 1, Math.max(1, y(strip.low[i]) - top));
  }
}

/** Call `draw` at most `rate` times a second, only while the page is seen: a little more often than messages come, ten a
 *  second, or every late one would cost a picture. */
export function throttled(draw, signal, rate = 14) {
  let wanted = false;
  let before = 0;
  function frame(now) {
    if (signal.aborted) return;
    if (wanted && now - before >= 1000 / rate - 2) { wanted = false; before = now; draw(); }
    requestAnimationFrame(frame);
  }
  requestAnimationFrame(frame);
  return () => { wanted = true; };
}
