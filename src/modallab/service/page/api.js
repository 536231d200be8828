/** The service's REST interface: what it rejects becomes a Problem, whose sentences can be shown as they are. */

const PREFIX = "/api/v1";
const PATIENCE_MS = 30000;
const OPERATOR = "modallab.operator";

/** Why a request was not done: RFC 9457, or that nobody answered. */
export class Problem extends Error {
  constructor(status, content) {
    super(content.detail ?? content.title ?? `status ${status}`);
    Object.assign(this, { status, code: content.code ?? "", detail: this.message, remedy: content.remedy ?? "" });
    this.errors = content.errors ?? [];
  }
}

/** Who works here, where the service's own token does not say it. */
export const operator = {
  get: () => localStorage.getItem(OPERATOR) ?? "",
  set: (name) => localStorage.setItem(OPERATOR, name),
};

let loggedOut = () => {};
/** Called when the service does not know this browser. */
export const onLoggedOut = (listener) => { loggedOut = listener; };

function headersOf(options) {
  const headers = { ...options.headers };
  // Headers are bytes: UTF-8, spelt as Latin-1.
  if (operator.get()) headers["Modallab-Operator"] = String.fromCharCode(...new TextEncoder().encode(operator.get()));
  if (options.lease) headers["Modallab-Lease"] = options.lease;
  if (options.json !== undefined) headers["Content-Type"] = "application/json";
  return headers;
}

/** The response of one request; paths that do not begin with `/` are of the API. */
export async function ask(method, path, options = {}) {
  const url = path.startsWith("/") ? path : `${PREFIX}/${path}`;
  const body = options.json === undefined ? options.body : JSON.stringify(options.json);
  let response;
  try {
    response = await fetch(url, { method, headers: headersOf(options), body, signal: AbortSignal.timeout(options.patience ?? PATIENCE_MS) });
  } catch {
    throw new Problem(0, { detail: "the service does not answer", remedy: "look whether it runs; the page comes back by itself" });
  }
  if (response.ok) return response;
  const content = await response.json().catch(() => ({ detail: `the service answered with status ${response.status}` }));
  if (response.status === 401 && path !== "session") loggedOut();
  throw new Problem(response.status, content);
}

const parsed = async (response) => (response.status === 204 ? null : response.json());

export const get = (path) => ask("GET", path).then(parsed);
export const post = (path, json = {}, options = {}) => ask("POST", path, { json, ...options }).then(parsed);
export const patch = (path, json, options = {}) => ask("PATCH", path, { json, ...options }).then(parsed);
export const drop = (path, options = {}) => ask("DELETE", path, options).then(parsed);

/** What is there, or null where there is none yet. */
export async function find(path) {
  try { return await get(path); } catch (error) {
    if (error.status === 404 || error.status === 409) return null;
    throw error;
  }
}

/** All items of a list that comes page by page. */
export async function all(path, most = 2000) {
  const found = [];
  const mark = path.includes("?") ? "&" : "?";
  for (let cursor = ""; found.length < most;) {
    const page = await get(`${path}${mark}limit=500${cursor && `&cursor=${encodeURIComponent(cursor)}`}`);
    found.push(...page.items);
    if (!page.next) break;
    cursor = page.next;
  }
  return found;
}

/** Address of a WebSocket of the API. */
export const socket = (path) => `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}${PREFIX}/${path}`;
