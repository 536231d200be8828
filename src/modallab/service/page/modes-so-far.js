/** The modes of a run as far as it has come, each with its standard deviation, and whether that is enough. */

import { post } from "./api.js";
import { h, panel, put, say, table } from "./dom.js";
import { waitForJob } from "./jobs.js";
import { number, uncertain } from "./numbers.js";

/** Asks for the modes again whenever other blocks count, one question at a time; `changed` is called with each answer. */
export class ModesSoFar {
  constructor(run, signal, changed) {
    Object.assign(this, { run, signal, changed, asked: "", busy: false, enough: false });
    this.verdict = h("p", { class: "verdict good", role: "status", hidden: true }, "Enough");
    this.words = h("p", { class: "muted", role: "status" }, "The modes appear after the first good hits.");
    this.agreement = h("p", { role: "status", hidden: true });
    this.list = h("div");
    this.element = panel("Modes so far", this.agreement, this.verdict, this.words, this.list);
  }

  /** Look at the blocks of a `RunState`. */
  async look({ blocks, plan }) {
    this.wanted = [...blocks.values()].filter(({ accepted }) => accepted).map(({ n }) => n).join(" ");
    if (this.busy) return;
    this.busy = true;
    while (this.wanted && this.wanted !== this.asked && !this.signal.aborted) {
      this.asked = this.wanted;
      try { this.draw((await waitForJob((await post(`runs/${this.run}/estimates`)).id, () => {}, this.signal)).result.document, plan); } catch (error) {
        if (!this.signal.aborted && !this.list.firstChild) say(this.words, "More good hits are needed.");
      }
    }
    this.busy = false;
  }

  draw({ frequency_hz: hz, frequency_sigma_hz: hzSigma, damping_ratio: zeta, damping_sigma: zetaSigma, blocks, telling_point: point, agreement }, { precision }) {
    this.compare(agreement);
    if (!hz.length) return say(this.words, "More good hits are needed for the modes.");
    const limits = [precision?.frequency_ratio, precision?.damping_ratio];
    const rows = hz.map((_, n) => [hzSigma[n] / hz[n], zetaSigma[n] / zeta[n]]);
    const met = rows.map((row) => row.every((ratio, k) => Number.isFinite(ratio) && ratio <= limits[k]));
    this.enough = Boolean(precision) && met.length > 0 && met.every(Boolean);
    this.verdict.hidden = !this.enough;
    this.changed();
    say(this.words, `From ${blocks} good ${blocks === 1 ? "hit" : "hits"}. ${this.goal(limits, met)}${point && !this.enough ? ` A hit at point ${point} would tell most.` : ""}`);
    const heads = [["Mode", "n"], ["Frequency [Hz]", "n"], ["± [%]", "n"], ["Damping [%]", "n"], ["± [%]", "n"], ...(precision ? ["Known well enough"] : [])];
    put(this.list, table("Modes so far, each with its standard deviation", heads, rows.map((row, n) => [n + 1, uncertain(hz[n], hzSigma[n]), number(100 * row[0], 2), uncertain(100 * zeta[n], 100 * zetaSigma[n]), number(100 * row[1], 2),
      ...(precision ? [h("span", { class: met[n] ? "good" : "warn" }, met[n] ? "yes" : "not yet")] : [])])));
  }

  /** Whether the simulation agrees with the hits at this point, so that a wrong sensor is seen before the next. */
  compare(agreement) {
    this.agreement.hidden = !agreement;
    if (!agreement) return;
    this.agreement.className = agreement.agrees ? "good" : "warn";
    say(this.agreement, agreement.sentence);
  }

  goal([hz, zeta], met) {
    if (hz === undefined) return "The plan has no target: set Precision under All settings.";
    const goal = `The target: ${number(100 * hz, 2)} % of every frequency and ${number(100 * zeta, 2)} % of every damping ratio`;
    return met.every(Boolean) ? `${goal}, is met: the test may be ended.` : `${goal}.`;
  }
}
