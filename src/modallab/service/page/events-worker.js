/** One stream of events for all tabs of a browser: browsers allow only few connections to one server. */

const AGAIN_MS = 1000;
const KINDS = ["state", "hit_requested", "hit_rejected", "hit_too_early", "waiting_for_rest", "decision_requested", "block",
  "dropped", "accepted", "verdict", "progress", "notice", "failed", "job", "rig", "tripped", "reset"];

const ports = new Set();
let stream = null;
let last = null;
let timer = 0;
let state = "connecting";

const post = (message) => ports.forEach((port) => port.postMessage(message));

function become(next) {
  state = next;
  post({ state });
}

function open() {
  clearTimeout(timer);
  stream?.close();
  stream = new EventSource(`/api/v1/events/stream${last === null ? "" : `?after=${last}`}`);
  stream.onopen = () => become("connected");
  stream.onerror = () => {
    become("lost");
    // A browser tries again by itself after a broken connection, but not after an answer that is an error.
    if (stream.readyState === EventSource.CLOSED) timer = setTimeout(open, AGAIN_MS);
  };
  for (const kind of KINDS) {
    stream.addEventListener(kind, ({ data }) => {
      const event = JSON.parse(data);
      last = event.seq;
      post({ event });
    });
  }
}

function hear(port) {
  ports.add(port);
  port.onmessage = ({ data }) => {
    if (data === "leave") ports.delete(port);
    else if (data === "again") open();
  };
  port.postMessage({ state });
  if (!stream) open();
}

/** A page without shared workers imports this file and is its only port. */
export function alone() {
  const { port1, port2 } = new MessageChannel();
  hear(port1);
  return port2;
}

if (typeof SharedWorkerGlobalScope !== "undefined") self.onconnect = ({ ports: [port] }) => hear(port);
