/** Correct the beam of the rig file, or matrices, by a test: the numbers of the rig file, and those that the test gives. */

import { post } from "./api.js";
import { button, h, panel, put, show, table } from "./dom.js";
import { number, uncertain } from "./numbers.js";

const LOCAL = { "": ["nothing else", 0], mass: ["a mass at", 0.05], spring: ["a spring to ground at", 1000] };

export class Update {
  constructor(campaign, model) {
    const name = model.test ?? "FRFs";
    Object.assign(this, { campaign, model });
    this.kind = h("select", { "aria-label": "Parameter at a point" }, Object.entries(LOCAL).map(([value, [text]]) => h("option", { value }, text)));
    this.at = h("select", { "aria-label": "Point of it" }, [...new Set(model.output_points)].map((point) => h("option", { value: point }, String(point))));
    this.out = h("select", {}, h("option", { value: "" }, "none"), model.frequency_hz.map((_, n) => h("option", { value: n + 1 }, String(n + 1))));
    this.file = h("input", { type: "file", accept: ".json,application/json" });
    this.found = h("div", { role: "status" });
    this.element = panel(`Finite-element model, ${name}`,
      h("p", { class: "buttons" }, h("span", {}, "Estimate Young's modulus, density, thickness and clamp of the rig file's beam, and"), this.kind, this.at, h("label", {}, "mode held out of the fit, as a check: ", this.out)),
      h("p", { class: "buttons" }, h("label", {}, "Or estimate the parameters of your own stiffness and mass matrices (JSON file, format as in the API): ", this.file), button("Estimate", () => this.estimate())), this.found);
  }

  async estimate() {
    const asked = { test: this.model.test, held_out: this.out.value ? [Number(this.out.value)] : [], priors: {} };
    if (this.kind.value) asked.priors[`${this.kind.value}@${this.at.value}`] = { value: 0, sigma: LOCAL[this.kind.value][1] };
    if (this.file.files.length) {
      try { asked.matrices = JSON.parse(await this.file.files[0].text()); } catch { show({ message: "the file of matrices is no JSON", remedy: "write stiffness, mass and freedoms in the format of the API" }); return; }
      asked.priors = {};
    }
    this.fill(await post(`campaigns/${this.campaign}/model/updates`, asked));
  }

  fill(found) {
    const parameters = Object.entries(found.parameters).map(([name, one]) => [`${name.replaceAll("_", " ")}${one.unit ? ` [${one.unit}]` : ""}`, number(one.believed, 5), number(one.found, 5), `${number(one.interval[0], 5)} to ${number(one.interval[1], 5)}`, one.determined ? "yes" : "no"]);
    const off = (hz, n) => number(100 * (hz / found.measured_hz[n] - 1), 3);
    const modes = found.measured_hz.map((hz, n) => [n + 1, uncertain(hz, this.model.frequency_sigma_hz[n]), off(found.before_hz[n], n), off(found.after_hz[n], n), number(found.mac_after[n], 3), found.held_out.includes(n + 1) ? "not in the fit" : ""]);
    put(this.found, table("Parameters", [["Parameter"], ["Rig file", "n"], ["Found", "n"], ["95 % interval", "n"], ["Determined"]], parameters),
      table("Modes of the model", [["Mode", "n"], ["Measured [Hz]", "n"], ["Before [%]", "n"], ["After [%]", "n"], ["MAC", "n"], [""]], modes), h("p", { class: "muted" }, found.notes.join(" ")));
  }
}
