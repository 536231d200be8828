/** What all tests have in common: no run, a run that is on, a run that has ended. */

import { button, h, put } from "./dom.js";
import { campaign, command, lab, newestRun } from "./lab.js";
import { planForm } from "./forms.js";
import { get, post } from "./api.js";
import { lease, look } from "./lab.js";
import { followRun } from "./run.js";

/** Show a test: `form` says what is asked for first, `like` names a run to begin from, `parts(view, signal)` makes what shows a run and returns its `draw`. */
export async function showTest(view, signal, { test, title, form, parts, like }) {
  const place = h("div");
  put(view, h("h1", {}, title), place);
  let inner = new AbortController();
  signal.addEventListener("abort", () => inner.abort());
  const renew = () => { inner.abort(); inner = new AbortController(); return inner.signal; };

  async function offer() {
    const own = renew();
    const name = h("input", { id: "session", value: "", placeholder: "today's" });
    const start = like ? (await get(`runs/${like}`)).plan : form.start(lab.description);
    const made = await planForm({ ...form, start, signal: own, begin: async (plan) => {
      const into = await campaign(name.value.trim());
      const run = await post(`campaigns/${into.id}/runs`, { plan }, { lease: await lease(), headers: { "Idempotency-Key": crypto.randomUUID?.() ?? String(Math.random()).slice(2) + Date.now() } });
      await look();
      await go(run.id);
    } });
    if (!own.aborted) put(place, h("section", { class: "panel", "aria-label": "Plan" }, h("h2", {}, "Plan"), h("div", { class: "field" }, h("label", { for: "session" }, "Campaign"), name), made));
  }

  async function go(id) {
    const own = renew();
    const again = h("p", { class: "buttons", hidden: true }, button("New test", offer));
    const shown = h("div");
    put(place, again, shown);
    const draw = parts(shown, own, id);
    await followRun(id, (state, event) => {
      if (own.aborted) return;
      again.hidden = !state.ended;
      draw(state, event);
    }, own);
  }

  const run = await newestRun(test);
  if (signal.aborted) return;
  if (lab.rig.run && run?.id === lab.rig.run) await go(run.id);
  else await offer();
}

/** Send a command to a run. */
export const order = (run, kind, more = {}) => command(`runs/${run}/commands`, { kind, ...more });

/** Buttons that every run has. */
export function runButtons(id) {
  let state = null;
  const pause = button("Pause", () => order(id, state?.state === "paused" ? "resume" : "pause"), { "aria-keyshortcuts": "p" });
  const end = button("End, keep the blocks", () => order(id, "stop"));
  const abort = button("Abort, mark as invalid", () => order(id, "abort"), { class: "plain" });
  return { elements: [pause, end, abort], draw: (now) => {
    state = now;
    pause.textContent = now.state === "paused" ? "Go on (P)" : "Pause (P)";
    for (const one of [pause, end, abort]) one.hidden = now.ended;
  }, pause: () => order(id, state?.state === "paused" ? "resume" : "pause") };
}
