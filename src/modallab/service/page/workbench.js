/** A workbench: hang masses, springs, dampers, absorbers on a modelled structure by clicking on its points, and see what they do. */

import { get, post } from "./api.js";
import { Chart, look, positive } from "./charts.js";
import { button, h, panel, put, show, svg, table } from "./dom.js";
import { number, uncertain } from "./numbers.js";
import { Moving3D, motions } from "./shape.js";

/** What can be hung there: its name, the unit and first value of its size, none of a rigid hold. */
const KINDS = {
  mass_kg: ["Mass", "kg", 0.05],
  spring_n_per_m: ["Spring to ground", "N/m", 1000],
  damper_n_s_per_m: ["Damper to ground", "N s/m", 1],
  absorber: ["Best absorber of a mode", "kg", 0.05],
  link: ["Rigid link to ground", "", ""],
};
const WIDTH = 640, HEIGHT = 150, EDGE = 30;

/** What hangs on each structure: the view is filled anew whenever something was computed. */
const HUNG = new Map();

export class Workbench {
  constructor(campaign, model, shapes, signal) {
    const key = `${campaign} ${model.test}`;
    if (!HUNG.has(key)) HUNG.set(key, []);
    Object.assign(this, { campaign, model, shapes, changes: HUNG.get(key), before: motions(shapes.motion), after: null });
    const id = `work-${model.test ?? "frf"}`;
    this.known = [...new Set([...model.output_points, ...model.input_points])].filter((point) => point !== null);
    this.kind = h("select", { id: `${id}-kind`, onchange: () => this.choose() }, Object.entries(KINDS).map(([value, [text]]) => h("option", { value }, text)));
    this.size = h("input", { id: `${id}-size`, type: "number", step: "any", value: "0.05" });
    this.unit = h("span", {}, "kg");
    this.calmed = h("select", { "aria-label": "Mode of the absorber", hidden: true }, model.frequency_hz.map((hz, n) => h("option", { value: n + 1 }, `mode ${n + 1}: ${number(hz, 5)} Hz`)));
    const points = (selected) => h("select", { onchange: () => this.predict() }, this.known.map((point) => h("option", { value: point, selected: point === selected }, String(point))));
    this.at = points(model.input_points[0]);
    this.of = points(model.input_points[0]);
    this.drawing = h("div", {});
    this.list = h("ul", { class: "plainlist" });
    this.modes = h("div");
    this.said = h("div");
    this.against = h("select", { onchange: () => this.predict() }, h("option", { value: "" }, "none yet"));
    this.chart = new Chart({ name: "Mobility before and after", x: "Frequency [Hz]", y: "Mobility [m/(N s)]", log: true, height: 300 });
    signal.addEventListener("abort", () => this.chart.close());
    this.mode = h("select", { "aria-label": "Mode whose shape is shown" });
    this.moving = h("div", { hidden: true }, new Moving3D("Shapes before and after", shapes, () => this.pair(), signal).element,
      h("p", { class: "buttons" }, h("label", {}, "Shape of mode ", this.mode), h("span", { class: "muted" }, "thin: at rest; grey: before; in colour: after")));
    this.element = panel(`Workbench, ${model.test ?? "FRFs"}`,
      h("p", { class: "buttons" }, h("label", { for: this.kind.id }, "Add"), this.kind, h("label", { for: this.size.id, class: "hidden" }, "Size"), this.size, this.unit, this.calmed, h("span", { class: "muted" }, "at a point: click on it")),
      this.drawing, this.list,
      h("p", { class: "buttons" }, h("label", {}, "Force at ", this.at), h("label", {}, "motion of ", this.of)),
      this.chart.element, this.moving, this.modes,
      h("p", { class: "buttons" }, button("Save the plan of a test that checks it", () => this.save()), h("label", {}, "Measured with it: ", this.against)), this.said);
    this.draw();
    this.others();
    this.predict();
  }

  /** Where each point is, from the side or from above: along the two axes over which the points spread most. */
  places() {
    const here = this.shapes.points.map((id, n) => [id, this.shapes.places_m[n]]).filter(([id]) => id === 0 || this.known.includes(id));
    const along = [0, 1, 2].map((axis) => here.map(([, place]) => place[axis]));
    const spans = along.map((values) => Math.max(...values) - Math.min(...values));
    const [first, second] = [0, 1, 2].sort((a, b) => spans[b] - spans[a]);
    const scale = Math.min((WIDTH - 2 * EDGE) / (spans[first] || 1), (HEIGHT - 2 * EDGE) / (spans[second] || 1e-9));
    const low = (n) => Math.min(...along[n]);
    return here.map(([id], k) => ({ id, x: EDGE + (along[first][k] - low(first)) * scale, y: spans[second] ? HEIGHT - EDGE - (along[second][k] - low(second)) * scale : HEIGHT / 2 }));
  }

  draw() {
    const held = new Set(this.changes.map(({ at }) => at));
    const places = this.places();
    const clamp = places.find(({ id }) => id === 0);
    const marks = places.filter(({ id }) => id !== 0).map(({ id, x, y }) => svg("g", { role: "button", tabindex: "0", class: "pick", "aria-label": `Add at point ${id}`, onclick: () => this.add(id), onkeydown: (event) => { if (event.key === "Enter") this.add(id); } },
      svg("circle", { class: `point${held.has(id) ? " next" : ""}`, cx: x, cy: y, r: held.has(id) ? 11 : 8 }), svg("text", { x, y: y + 27 }, String(id))));
    const line = clamp ? svg("line", { class: "body", x1: clamp.x, y1: clamp.y, x2: Math.max(...places.map(({ x }) => x)), y2: clamp.y }) : null;
    put(this.drawing, svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "beam work", role: "group", "aria-label": "Points of the structure" }, line, marks));
  }

  choose() {
    const [, unit, first] = KINDS[this.kind.value];
    this.size.value = String(first);
    this.unit.textContent = unit;
    this.size.hidden = !unit;
    this.calmed.hidden = this.kind.value !== "absorber";
  }

  async add(at) {
    const size = Number(this.size.value), kind = this.kind.value;
    if (kind !== "link" && (!Number.isFinite(size) || size === 0)) { show({ message: "the size is no number", remedy: "type a number other than 0" }); return; }
    try {
      const change = await this.change(kind, at, size);
      this.changes.push(change);
      this.draw();
      // What is rejected does not hang there.
      if (!await this.predict()) { this.changes.splice(this.changes.indexOf(change), 1); this.draw(); }
    } catch (error) { show(error); }
  }

  async change(kind, at, size) {
    if (kind === "link") return { kind, at };
    if (kind !== "absorber") return { kind: "element", at, [kind]: size };
    const found = await post(`campaigns/${this.campaign}/model/absorbers`, { test: this.model.test, mode: Number(this.calmed.value), at, mass_kg: size });
    return { kind, at, mass_kg: size, frequency_hz: found.frequency_hz, damping_ratio: found.damping_ratio };
  }

  /** What the changes do; of several clicks in a row the last one counts. */
  async predict() {
    this.asked = (this.asked ?? 0) + 1;
    const asked = this.asked;
    const { campaign, model: { test }, at: { value: at }, of: { value: of } } = this;
    try {
      if (!this.changes.length) {
        this.moving.hidden = true; this.after = null; put(this.said); put(this.list); put(this.modes, h("p", { class: "muted" }, "Nothing is added yet."));
        const { frequency_hz: hz, values: { re: [[re]], im: [[im]] } } = await get(`campaigns/${campaign}/model/frf?outputs=${of}&inputs=${at}${test ? `&test=${test}` : ""}`);
        if (asked === this.asked) this.chart.draw([{ label: "before", ...look(0) }], [hz, size({ re, im })]);
        return true;
      }
      const found = await post(`campaigns/${campaign}/model/modifications`, { test, changes: this.changes, frf: { at: Number(at), of: Number(of) }, check: this.against.value || null });
      if (asked === this.asked) this.fill(found);
      return true;
    } catch (error) { show(error); return false; }
  }

  fill(found) {
    this.words = found.changes;
    put(this.list, found.changes.map((one, n) => h("li", {}, one, " ", button("Remove", () => { this.changes.splice(n, 1); this.draw(); return this.predict(); }))));
    this.chart.draw([{ label: "before", ...look(0) }, { label: "after", ...look(1) }], [found.frf.frequency_hz, size(found.frf.before), size(found.frf.after)]);
    const heads = [["Mode", "n"], ["Before [Hz]", "n"], ["After [Hz]", "n"], ["Shift [%]", "n"], ["Damping after [%]", "n"]];
    const rows = found.frequency_hz.map((hz, n) => {
      const before = found.mac[n] < 0.5 ? NaN : found.before_hz[found.like[n] - 1];
      return [n + 1, Number.isFinite(before) ? number(before, 6) : "new", uncertain(hz, found.frequency_sigma_hz[n]), Number.isFinite(before) ? uncertain(100 * (hz / before - 1), (100 * found.frequency_sigma_hz[n]) / before) : "–", uncertain(100 * found.damping_ratio[n], 100 * found.damping_sigma[n])];
    });
    put(this.modes, table("Modes before and after", heads, rows), h("p", { class: "muted" }, found.notes.join(" ")));
    const chosen = this.mode.value || "0";
    put(this.mode, found.frequency_hz.map((hz, n) => h("option", { value: n }, `${n + 1}: ${number(hz, 5)} Hz`)));
    this.mode.value = Number(chosen) < found.frequency_hz.length ? chosen : "0";
    this.after = found.motion && { motion: motions(found.motion), like: found.like.map((one, n) => (found.mac[n] < 0.5 ? null : one - 1)) };
    this.moving.hidden = !this.after;
    put(this.said, found.checked.length ? h("ul", { class: "plainlist" }, found.checked.map((one) => h("li", { class: one.inside ? "" : "bad" }, one.words))) : null);
  }

  /** The shape that is shown after the changes, and the one before that is most like it, in the same sense. */
  pair() {
    if (!this.after) return [];
    const n = Number(this.mode.value), after = this.after.motion[n], like = this.after.like[n];
    if (like === null) return [{ motion: after, colour: "trace" }];
    const before = this.before[like];
    const sense = before.flat().reduce((sum, [re], k) => sum + re * after.flat()[k][0], 0) < 0 ? -1 : 1;
    return [{ motion: before.map((place) => place.map(([re, im]) => [sense * re, sense * im])), colour: "muted" }, { motion: after, colour: "trace" }];
  }

  /** Campaigns that may have been measured with the changes. */
  async others() {
    const found = (await get("campaigns?limit=50")).items.filter(({ id, runs }) => id !== this.campaign && runs.length);
    this.against.append(...found.map((one) => h("option", { value: one.id }, one.name)));
  }

  /** An impact test at the points that were driven, named for what is to be hung there. */
  save() {
    const name = (this.changes.length && this.words ? this.words : ["nothing added"]).join(", ");
    const plan = { kind: "impact", points: [...new Set(this.model.input_points)] };
    const link = h("a", { href: URL.createObjectURL(new Blob([`# ${name}\n${JSON.stringify(plan)}\n`], { type: "application/yaml" })), download: "check-the-change.yaml" });
    link.click();
    URL.revokeObjectURL(link.href);
  }
}

function size({ re, im }) { return positive(re.map((value, n) => Math.hypot(value, im[n]))); }
