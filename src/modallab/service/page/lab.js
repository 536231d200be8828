/** What the page knows of the service: the rigs, the one it works at, who works here, and the lease. */

import { ask, drop, find, get, operator, post } from "./api.js";
import { onConnection, onEvent } from "./events.js";

const LEASE_S = 60;
const RIG = "modallab.rig";

export const lab = new EventTarget();
Object.assign(lab, { caller: null, rigs: [], rig: null, description: null, health: null, lease: null, operator: "", test: "impact" });

const changed = () => lab.dispatchEvent(new Event("change"));

/** Call now and with every change until `signal` is aborted. */
export function watch(listener, signal) {
  lab.addEventListener("change", listener, { signal });
  listener();
}

/** Read everything again. */
export async function refresh() {
  const [caller, rigs, health] = await Promise.all([get("me"), get("rigs"), get("/health")]);
  Object.assign(lab, { caller, rigs: rigs.items, health, operator: caller.name || operator.get() });
  const known = lab.rig?.id ?? localStorage.getItem(RIG);
  await choose((lab.rigs.find(({ id }) => id === known) ?? lab.rigs[0])?.id);
}

/** Work at another rig. */
export async function choose(id) {
  const before = lab.rig?.id;
  lab.rig = lab.rigs.find((rig) => rig.id === id) ?? null;
  if (lab.rig && (before !== id || !lab.description)) {
    localStorage.setItem(RIG, id);
    lab.description = await get(`rigs/${id}/description`);
    if (before !== undefined && before !== id) lab.lease = null;
    await nameTest();
  }
  changed();
}

/** The test that is on: sensitivities may stand differently in each. */
async function nameTest() {
  if (lab.rig?.run) lab.test = (await find(`runs/${lab.rig.run}`))?.test ?? lab.test;
}

/** Read the rig that is worked at. */
export async function look() {
  if (!lab.rig) return;
  const found = await get(`rigs/${lab.rig.id}`);
  lab.rigs = lab.rigs.map((rig) => (rig.id === found.id ? found : rig));
  if (lab.rig.id === found.id) {
    const begun = found.run && found.run !== lab.rig.run;
    if (found.rig_hash !== lab.rig.rig_hash) lab.description = await get(`rigs/${found.id}/description`);
    lab.rig = found;
    if (begun) await nameTest();
  }
  changed();
}

let renewing = 0;

async function hold(lease) {
  lab.lease = lease;
  clearInterval(renewing);
  renewing = setInterval(renew, (LEASE_S * 1000) / 3);
  await look();
  return lease.id;
}

async function renew() {
  if (!lab.lease) { clearInterval(renewing); return; }
  try { await ask("PUT", `rigs/${lab.lease.rig}/lease`, { lease: lab.lease.id }); } catch (error) {
    // Without an answer it may still be held.
    if (error.status) { lab.lease = null; clearInterval(renewing); await look().catch(() => {}); }
  }
}

/** The id of the lease: the one held, the one held before this page was loaded, or a new one. */
export async function lease({ takeOver = false } = {}) {
  if (lab.lease) return lab.lease.id;
  const path = `rigs/${lab.rig.id}/lease`;
  const about = { operator: lab.operator || "operator", ttl_s: LEASE_S };
  await look();
  // Held before this page was loaded, or by another tab: then it is the same one.
  const own = !takeOver && lab.rig.lease?.operator === about.operator;
  return hold(await post(path, own ? { ...about, recover: true } : { ...about, take_over: takeOver }));
}

/** Give it back. */
export async function release() {
  const held = lab.lease;
  lab.lease = null;
  clearInterval(renewing);
  if (held) await drop(`rigs/${held.rig}/lease`, { lease: held.id });
  await look();
}

/** Have a command done under the lease; one that counts no longer is taken again once. */
export async function command(path, content = {}) {
  try { return await post(path, content, { lease: await lease() }); } catch (error) {
    if (!["lease-needed", "lease_needed"].includes(error.code)) throw error;
    lab.lease = null;
    return post(path, content, { lease: await lease() });
  }
}

/** The campaign that runs are recorded into: of today and this revision of the rig, made when first needed. */
export async function campaign(name) {
  const label = name || `${lab.description?.name ?? lab.rig.id}, ${new Date().toISOString().slice(0, 10)}`;
  const later = `${label}, revision `;
  const { items } = await get(`campaigns?rig=${encodeURIComponent(lab.rig.id)}&limit=50`);
  const known = items.filter((item) => item.name === label || item.name.startsWith(later));
  for (const one of known) {
    const last = one.runs.at(-1);
    if (!last || (await get(`runs/${last}`)).rig_hash === lab.rig.rig_hash) return one;
  }
  const number = known.length ? (await get(`rigs/${lab.rig.id}/revisions`)).items.length : 0;
  return post("campaigns", { name: number ? `${later}${number}` : label, rig: lab.rig.id });
}

/** The run that is on, or else the newest of the rig. */
export async function newestRun(test) {
  const fits = (run) => !test || [test].flat().includes(run.test);
  if (lab.rig?.run) {
    const run = await find(`runs/${lab.rig.run}`);
    if (run && fits(run)) return run;
  }
  for (const { runs } of (await get(`campaigns?rig=${encodeURIComponent(lab.rig.id)}&limit=10`)).items) {
    for (const id of [...runs].reverse()) {
      const run = await get(`runs/${id}`);
      if (fits(run)) return run;
    }
  }
  return null;
}

const LOOKED_AT = new Set(["state", "rig", "tripped", "reset"]);
onEvent((event) => { if (LOOKED_AT.has(event.kind) && event.rig === lab.rig?.id) look().catch(() => {}); });
onConnection((state) => { if (state === "connected" && lab.caller) refresh().catch(() => {}); });
