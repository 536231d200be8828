/** The parts of a diagnosis as pictures and tables. */

import { h, panel, sentence, svg, table } from "./dom.js";
import { lab } from "./lab.js";
import { number, percent } from "./numbers.js";

const STAGES = ["excitation", "structure", "sensor", "acquisition"];
const SMALLEST = 0.0005;
const spaced = (text) => text.replaceAll("_", " ");
const [BAR_WIDTH, BAR_HEIGHT] = [110, 12];

/** Where the gap lies: in the chain, and on the beam. */
export function where({ stage, x_m: x, channels: rows, why, share }) {
  const points = lab.description.points;
  const length = lab.description.beam?.length_m ?? Math.max(...points.map(({ x_m: at }) => at));
  const at = (place) => 30 + (place / length) * 580;
  return panel("Where", h("ol", { class: "chain", "aria-label": "Stages of the measurement" }, STAGES.map((one) => h("li", { "aria-current": one === stage && "true" }, one))),
    svg("svg", { viewBox: "0 0 640 80", class: "beam", role: "img", "aria-label": x === null ? "The beam; the gap has no place on the beam" : `The beam; the gap lies at ${number(x, 3)} m` },
      svg("rect", { class: "body", x: 30, y: 40, width: 580, height: 8 }), points.map(({ id, x_m: place }) => svg("text", { x: at(place), y: 68 }, String(id))),
      x !== null && svg("circle", { class: "point next", cx: at(x), cy: 44, r: 10 }), x !== null && svg("text", { class: "next", x: at(x), y: 24 }, `${number(x, 3)} m`)),
    rows.length > 0 && h("p", {}, `Channels: ${rows.join(", ")}. They contain ${percent(share, 2)} of the gap.`), h("ul", { class: "plainlist" }, why.map((one) => h("li", {}, sentence(one)))));
}

/** What a gap behaves like that no effect explains: law, numbers, and how much of it that closes. */
export function described(found, numbers) {
  if (!found) return null;
  const { says, shrink: shrunk, alternatives } = found;
  return panel("Description of the unnamed cause", h("p", {}, `The gap behaves like ${says.replace(/,+$/, "")}.`),
    shrunk.closed !== null && h("p", {}, h("strong", {}, `The description closes ${closed(shrunk.closed)} of the gap`), ` on ${shrunk.held_out.length} held-out records: from ${number(shrunk.before, 3)} to ${number(shrunk.after, 3)} noise units. The description is no cause: other causes may behave alike.`),
    table("Its numbers", ["Number", ["Value", "n"], ["95 % interval", "n"]], numbers),
    alternatives.length > 0 && h("ul", { class: "plainlist" }, alternatives.map((other) => h("li", {}, `${sentence(other.says)} Remaining gap: ${number(other.gap, 3)} noise units.`))));
}

/** Shrinkage of the gap on held-out records. */
export function shrink(found) {
  const rows = [["Gap before", `${number(found.before, 3)} noise units`], ["Gap after", `${number(found.after, 3)} noise units`], ["Closed", found.closed === null ? "–" : closed(found.closed)],
    found.interval && ["95 % interval", `${closed(found.interval[0])} to ${closed(found.interval[1])}`]].filter(Boolean);
  return panel("On held-out records", table("Shrinkage of the gap", ["", ["", "n"]], rows),
    Object.entries(found.rival).map(([name, value]) => h("p", {}, `The best other explanation, ${spaced(name).replaceAll("+", " and ")}, closes ${closed(value)}.`)), h("p", { class: "muted" }, `${found.held_out.length} records were held out.`));
}

/** As many nines as count. */
const closed = (share) => percent(share, share > 0.9 ? Math.min(6, 3 + Math.floor(-Math.log10(Math.max(1 - share, 1e-4)))) : 3);

function bar(share) {
  const text = Math.abs(share) < SMALLEST ? "below 0.05 %" : percent(share, 2);
  const size = Math.max(0, Math.min(1, Math.abs(share)));
  return h("span", { class: "bar" }, svg("svg", { class: `share${share < 0 ? " against" : ""}`, width: BAR_WIDTH, height: BAR_HEIGHT, "aria-hidden": "true" },
    svg("rect", { class: "all", width: BAR_WIDTH, height: BAR_HEIGHT, rx: 3 }), svg("rect", { class: "part", width: size * BAR_WIDTH, height: BAR_HEIGHT, rx: 3 })), ` ${text}`);
}

/** Explanations, the likeliest first, and how probable a cause without a name is. */
export function candidates(found, unknown) {
  const rows = found.slice(0, 8).map((one) => [spaced(one.effects.join(" and ")) || "none", bar(Math.min(one.probability, 0.99)), `${number(one.gap, 3)}`]);
  if (unknown !== null && found.length) rows.push(["an unnamed cause", bar(Math.min(unknown, 0.99)), "–"]);
  return panel("Candidates", found.length ? table("Candidates with their probability", ["Explanation", "Probability", ["Gap left", "n"]], rows) : h("p", { class: "muted" }, "There are none."));
}

/** By channel, on a logarithmic scale that begins at noise alone. */
export function residuals({ by_channel: before, after_by_channel: after }) {
  const most = Math.log10(Math.max(10, ...Object.values(before), ...Object.values(after)));
  const length = (value) => Math.max(0, Math.min(1, Math.log10(Math.max(1, value)) / most)) * BAR_WIDTH;
  const bars = (name) => svg("svg", { class: "share", width: BAR_WIDTH, height: 16, role: "img", "aria-label": `${name}: ${number(before[name], 3)} before, ${number(after[name], 3)} after` },
    svg("rect", { class: "before", width: length(before[name]), height: 7, rx: 2 }), svg("rect", { class: "part", y: 8, width: length(after[name]), height: 7, rx: 2 }));
  return panel("Residual before and after", table("Residual by channel, in noise units", ["Channel", "", ["Before", "n"], ["After", "n"]], Object.keys(before).map((name) => [name, bars(name), number(before[name], 3), number(after[name], 3)])),
    h("p", { class: "muted" }, "In noise units: 1 is noise alone. The bars are logarithmic from 1; the lower bar is the gap after."));
}

/** What the gap is made of. */
export const budget = (found) => panel("Budget of the gap", found ? [table("Parts of the gap", ["Part", "Share", ["Off [σ]", "n"]], found.rows.slice(0, 12).map((row) => [row.said, bar(row.share), row.sigmas === null ? "–" : (Math.round(10 * row.sigmas) / 10 || 0).toFixed(1).replace("-", "−")])),
  h("p", { class: "muted" }, "Deviations whose shares cancel are summed in one row."), h("ul", { class: "plainlist" }, found.calibrate.map((one) => h("li", {}, sentence(one))))] : h("p", { class: "muted" }, "This diagnosis has no budget."));
