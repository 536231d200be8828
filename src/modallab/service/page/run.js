/** One run as its events tell it, from the first one on: what to do now, and what became of each block. */

import { all, get } from "./api.js";
import { onConnection, onEvent } from "./events.js";

const ENDED = new Set(["done", "failed", "aborted"]);

/** State of a run that grows with every event. */
export class RunState {
  constructor(view) {
    Object.assign(this, { view, id: view.id, plan: view.plan, seq: 0, state: view.state, phase: "", point: null, hit: 0, of: 0 });
    Object.assign(this, { rest: null, last: null, progress: null, notices: [], failed: null, reason: view.reason, begun: null, pace: [] });
    this.blocks = new Map();
  }

  get ended() { return ENDED.has(this.state); }

  /** Good blocks by point. */
  get counts() {
    const counts = {};
    for (const block of this.blocks.values()) if (block.drive_point !== null) counts[block.drive_point] = (counts[block.drive_point] ?? 0) + Number(block.accepted);
    return counts;
  }

  /** Take one event; whether it was news. */
  take({ seq, kind, content, utc }) {
    if (seq <= this.seq) return false;
    this.seq = seq;
    this[`on_${kind}`]?.(content, utc);
    return true;
  }

  on_state({ state, reason }) {
    this.state = state;
    this.reason = reason || this.reason;
    if (this.ended || state === "paused") { this.phase = state; this.point = null; }
    else if (["ready", "paused"].includes(this.phase) && state !== "acquiring") this.phase = "";
    else if (this.phase === "paused") this.phase = "";
  }

  on_waiting_for_rest(content) { Object.assign(this, { phase: "waiting", rest: content, point: content.point, hit: content.hit, of: content.of }); }

  on_hit_requested({ point, hit, of }) { Object.assign(this, { phase: "ready", rest: null, point, hit, of }); }

  on_hit_too_early({ point, peak_n: peak }) { this.last = { verdict: "early", point, reason: `hit before the request, with ${peak.toPrecision(3)} N` }; this.phase = "early"; }

  on_hit_rejected({ point, reason }) {
    this.last = { ...(this.last?.fresh ? this.last : {}), fresh: false, verdict: "rejected", point, reason };
    this.phase = "rejected";
  }

  on_decision_requested({ n }) { this.phase = "decide"; this.asked = n ?? this.last?.n; }

  on_block(block, utc) {
    this.blocks.set(block.n, block);
    this.last = { verdict: block.accepted ? "good" : "rejected", n: block.n, point: block.drive_point, reason: block.reason, facts: block.facts, frequency: block.frequency_hz, fresh: true };
    if (block.accepted) this.phase = "good";
    this.pace = [...this.pace, Date.parse(utc)].slice(-6);
  }

  change(match, accepted, reason) {
    for (const block of this.blocks.values()) if (match(block)) Object.assign(block, { accepted, reason });
  }

  on_dropped({ name, reason }) { this.change((block) => block.name === name, false, reason); this.last = { verdict: "dropped", reason }; }

  on_accepted({ name, reason }) { this.change((block) => block.name === name, true, reason); if (this.last) this.last.verdict = "good"; }

  on_verdict({ n, accepted, reason }) { this.change((block) => block.n === n, accepted, reason); }

  on_progress(content) { this.progress = content; }

  on_notice({ what }) { this.notices = [...this.notices.filter((old) => old !== what), what].slice(-4); }

  on_failed(content) { this.failed = content; }

  /** Seconds that are left, by the pace of the last blocks; NaN while that cannot be said. */
  get remaining() {
    if (!this.progress || this.pace.length < 3 || this.ended) return NaN;
    const each = (this.pace.at(-1) - this.pace[0]) / (this.pace.length - 1) / 1000;
    return each * (this.progress.total - this.progress.done);
  }
}

/** Follow a run: `listener(state, event)` after all that has happened, then with each event that comes. */
export async function followRun(id, listener, signal) {
  const state = new RunState(await get(`runs/${id}`));
  let early = [];
  const take = (event) => { if (state.take(event)) listener(state, event); };
  onEvent((event) => { if (event.run === id) (early ? early.push(event) : take(event)); }, signal);
  const replay = async () => { for (const event of await all(`events?run=${encodeURIComponent(id)}`, 20000)) state.take(event); };
  await replay();
  for (const event of early) state.take(event);
  early = null;
  if (!signal.aborted) listener(state, null);
  // What came while nobody listened is read again.
  onConnection(async (connection) => {
    if (connection !== "connected") return;
    try { await replay(); listener(state, null); } catch { /* it is asked again with the next connection */ }
  }, signal);
  return state;
}
