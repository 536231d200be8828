/** Events of the service as they come; one connection serves all tabs. */

const target = new EventTarget();
let port = null;
let state = "connecting";

/** Begin to listen; again after a login. */
export async function listen() {
  if (port) { port.postMessage("again"); return; }
  if (typeof SharedWorker === "function") port = new SharedWorker(new URL("events-worker.js", import.meta.url), { type: "module", name: "modallab" }).port;
  else port = (await import("./events-worker.js")).alone();
  port.onmessage = ({ data }) => {
    if (data.event) target.dispatchEvent(new CustomEvent("event", { detail: data.event }));
    if (data.state && data.state !== state) {
      state = data.state;
      target.dispatchEvent(new CustomEvent("state", { detail: state }));
    }
  };
  addEventListener("pagehide", () => port.postMessage("leave"));
  addEventListener("pageshow", ({ persisted }) => { if (persisted) location.reload(); });
}

/** Call with each event until `signal` is aborted. */
export const onEvent = (listener, signal) => target.addEventListener("event", ({ detail }) => listener(detail), { signal });

/** Call with `connected` or `lost` whenever it changes. */
export const onConnection = (listener, signal) => target.addEventListener("state", ({ detail }) => listener(detail), { signal });
