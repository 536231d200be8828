/** The emergency stop: asked for in every way there is at once, so that the quickest counts. */

import { ask } from "./api.js";
import { h, say, show } from "./dom.js";
import { lab, look } from "./lab.js";

export const KEY = "Escape";
const PATIENCE_MS = 8000;
const senders = new Set();

/** A WebSocket that is open anyway may carry it; `send` says whether it could. */
export function addSender(send, signal) {
  senders.add(send);
  signal.addEventListener("abort", () => senders.delete(send));
}

const listener = () => {
  const url = new URL(lab.health.emergency_stop);
  url.searchParams.set("rig", lab.rig.id);
  url.searchParams.set("operator", lab.operator || "operator");
  return fetch(url, { method: "POST", signal: AbortSignal.timeout(PATIENCE_MS) }).then((response) => {
    if (!response.ok) throw new Error(`the stop's listener answered with ${response.status}`);
  });
};

/** Bring the output of the rig to 0 V, and latch it. */
export async function press() {
  if (!lab.rig) return;
  for (const send of senders) send(JSON.stringify({ kind: "emergency_stop", rig: lab.rig.id, operator: lab.operator || "operator", reason: "pressed on the operator's page" }));
  const rest = ask("POST", `rigs/${lab.rig.id}/emergency-stop`, { json: { reason: "pressed on the operator's page" }, patience: PATIENCE_MS });
  try {
    await Promise.any([listener(), rest]);
  } catch {
    show({ detail: "the emergency stop was not confirmed", remedy: "switch the amplifier off by hand now" });
  }
  look().catch(() => {});
}

/** The button, and the key while nothing is typed. */
export function stopButton() {
  const name = h("span", {}, "Stop");
  const button = h("button", { type: "button", class: "stop", onclick: press, "aria-label": `Emergency stop, key ${KEY}`, title: "Emergency stop: 0 V at once. Not a safety-rated stop." },
    name, h("kbd", { "aria-hidden": "true" }, "Esc"));
  addEventListener("keydown", (event) => {
    if (event.key === KEY && !event.repeat) { event.preventDefault(); press(); }
  }, { capture: true });
  lab.addEventListener("change", () => {
    button.disabled = !lab.rig;
    say(name, lab.rig?.trip ? "Stopped" : "Stop");
  });
  return button;
}
