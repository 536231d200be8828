/** The page: who is logged in, which view is shown, and the head that is always there. */

import { drop, get, onLoggedOut, operator, post } from "./api.js";
import { h, put, say, show as showError } from "./dom.js";
import { listen, onConnection } from "./events.js";
import { choose, lab, refresh, watch } from "./lab.js";
import { stopButton } from "./stop.js";

const VIEWS = { bench: "Bench", impact: "Impact test", sine: "Sine test", broadband: "Broadband test", model: "Model", gap: "Gap", campaigns: "Campaigns" };
const RETRY_MS = 1000;
const always = new AbortController().signal;
const view = document.getElementById("view");
let shown = new AbortController();
let began = false;

function head() {
  const rigs = h("select", { "aria-label": "Rig", onchange: ({ target }) => choose(target.value).then(route) });
  const link = h("span", { class: "lamp", role: "status" }, "connecting");
  const who = h("span", { class: "who" });
  const links = Object.entries(VIEWS).map(([name, text]) => h("a", { href: `#/${name}` }, text));
  put(document.getElementById("head"), h("strong", { class: "brand" }, "modallab"), h("nav", { "aria-label": "Views" }, links), rigs, link, who,
    h("button", { type: "button", class: "plain", onclick: leave }, "Log out"), stopButton());
  watch(() => {
    if (rigs.length !== lab.rigs.length) put(rigs, lab.rigs.map((rig) => h("option", { value: rig.id }, rig.name)));
    if (lab.rig) rigs.value = lab.rig.id;
    say(who, lab.operator);
  }, always);
  onConnection((state) => {
    link.className = `lamp ${state === "connected" ? "good" : "bad"}`;
    say(link, state === "connected" ? "connected" : "no connection, trying again");
  }, always);
}

async function leave() {
  await drop("session").catch(showError);
  location.reload();
}

function mark(name) {
  for (const link of document.querySelectorAll("nav a")) {
    if (link.hash.slice(2) === name) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  document.title = `${VIEWS[name]}, modallab`;
}

async function route() {
  if (!lab.caller) return;
  const [name] = location.hash.slice(2).split("/");
  const known = name in VIEWS ? name : "bench";
  shown.abort();
  shown = new AbortController();
  const { signal } = shown;
  mark(known);
  try {
    const module = await import(`./views/${known}.js`);
    if (!lab.rig) put(view, h("p", {}, "This service has no rig. Start it with one: modallab serve --rig rig.yaml"));
    else if (!signal.aborted) await module.show(view, signal, location.hash.slice(2).split("/").slice(1).map(decodeURIComponent));
  } catch (error) {
    if (!signal.aborted) showError(error);
  }
}

function login() {
  if (document.getElementById("login")) return;
  lab.caller = null;
  const token = h("input", { id: "token", type: "password", autocomplete: "current-password", required: true });
  const form = h("form", { id: "login", class: "panel narrow", onsubmit: async (event) => {
    event.preventDefault();
    try { await post("session", { token: token.value.trim() }); await begin(); } catch (error) { showError(error); }
  } }, h("h1", {}, "Log in"), h("label", { for: "token" }, "Token"), token,
  h("p", { class: "muted" }, "The service printed the file of its token at its start; each user has a separate token. `modallab serve --open` opens this page without asking for the token."),
  h("button", { type: "submit", class: "main" }, "Log in"));
  put(view, form);
  token.focus();
}

function askName() {
  const name = h("input", { id: "name", required: true, maxlength: 80, autocomplete: "name" });
  put(view, h("form", { id: "who", class: "panel narrow", onsubmit: (event) => {
    event.preventDefault();
    operator.set(name.value.trim());
    begin().catch(showError);
  } }, h("h1", {}, "Who works here?"), h("label", { for: "name" }, "Your name"), name,
  h("p", { class: "muted" }, "The audit record keeps this name."), h("button", { type: "submit", class: "main" }, "Go on")));
  name.focus();
}

async function begin() {
  const caller = await get("me");
  if (!caller.name && !operator.get()) { askName(); return; }
  document.getElementById("messages").replaceChildren();
  await refresh();
  if (!began) { head(); began = true; }
  await listen();
  await route();
}

onLoggedOut(login);
addEventListener("hashchange", () => route());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => route());

async function start() {
  try { await begin(); } catch (error) {
    if (error.status === 401) return;
    showError(error);
    setTimeout(start, RETRY_MS);
  }
}
start();
