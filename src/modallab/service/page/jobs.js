/** Work that the service computes beside: waited for by its events. */

import { get } from "./api.js";
import { onEvent } from "./events.js";

const ENDED = new Set(["done", "failed", "cancelled"]);
const LOOK_MS = 2000;

/** The job once it has ended; `notify` is called with it on the way. Throws what it failed with. */
export async function waitForJob(id, notify = () => {}, signal = undefined) {
  const own = new AbortController();
  signal?.addEventListener("abort", () => own.abort());
  let wake = () => {};
  onEvent((event) => { if (event.kind === "job" && JSON.stringify(event.content).includes(id)) wake(); }, own.signal);
  try {
    for (;;) {
      const job = await get(`jobs/${id}`);
      if (job.state === "done") return job;
      if (ENDED.has(job.state)) throw Object.assign(new Error(job.error ?? `the work was ${job.state}`), { detail: job.error ?? `the work was ${job.state}`, remedy: "check the recordings, and order the job again" });
      notify(job);
      if (own.signal.aborted) throw new DOMException("the view was left", "AbortError");
      await new Promise((resolve) => { wake = resolve; setTimeout(resolve, LOOK_MS); });
    }
  } finally { own.abort(); }
}

/** The newest job of a kind that is done, or that is not yet. */
export async function newestJob(campaign, kind) {
  const { items } = await get(`campaigns/${campaign}/jobs?kind=${kind}`);
  return { done: items.find(({ state }) => state === "done") ?? null, open: items.find(({ state }) => !ENDED.has(state)) ?? null, last: items[0] ?? null };
}
