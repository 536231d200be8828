/** Binary messages of the service by WebSocket, connected again by themselves. */

import { socket } from "./api.js";
import { show } from "./dom.js";

const AGAIN_MS = 500;
const SLOWEST_MS = 5000;
const ARRAYS = { "<f4": Float32Array, "<f8": Float64Array, "<c8": Float32Array, "<i2": Int16Array, "<i4": Int32Array };

/** [about, values] of one message: 4 bytes of length, JSON, an array. Complex numbers are pairs. */
export function parse(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const about = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  return [about, new ARRAYS[about.dtype](buffer.slice(4 + size))];
}

/** Follow an address until `signal` is aborted; returns a function that sends a text if it is connected. */
export function follow(path, listener, signal) {
  let connection = null;
  let wait = AGAIN_MS;
  function open() {
    if (signal.aborted) return;
    connection = new WebSocket(socket(path));
    connection.binaryType = "arraybuffer";
    connection.onopen = () => { wait = AGAIN_MS; };
    connection.onmessage = ({ data }) => listener(...parse(data));
    connection.onclose = ({ code, reason }) => {
      // What cannot be answered is not asked again.
      if (code === 4422) { show({ detail: reason }); return; }
      setTimeout(open, wait);
      wait = Math.min(2 * wait, SLOWEST_MS);
    };
  }
  signal.addEventListener("abort", () => connection?.close());
  open();
  return (text) => {
    if (connection?.readyState !== WebSocket.OPEN) return false;
    connection.send(text);
    return true;
  };
}
