/** Forms made from the API's own schema, which check as one types. */

import { get, post } from "./api.js";
import { h, put } from "./dom.js";
import { lab } from "./lab.js";
import { duration } from "./numbers.js";

const CHECK_MS = 400;
let document_ = null;

/** The schema of a document of the API. */
async function schemaOf(name) {
  document_ ??= await get("/openapi.json");
  return resolve(document_.components.schemas[name]);
}

const resolve = (schema) => (schema?.$ref ? document_.components.schemas[schema.$ref.split("/").at(-1)] : schema);

/** Without the null that says that a field may be left out. */
function plain(schema) {
  const found = resolve(schema);
  if (!found.anyOf) return found;
  const kinds = found.anyOf.filter(({ type }) => type !== "null");
  return kinds.length === 1 ? { ...found, anyOf: undefined, ...resolve(kinds[0]), optional: true } : found;
}

const LISTS = new Set(["number", "integer"]);
const UNITS = [["_hz", "Hz"], ["_n", "N"], ["_s", "s"], ["_v", "V"], ["_db", "dB"]];

/** What a field is called and its unit. */
function label(name, stated) {
  const [ending, byName] = UNITS.find(([end]) => name.endsWith(end)) ?? ["", ""];
  const unit = stated && stated !== "1" ? stated : byName;
  const words = name.slice(0, name.length - ending.length).replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1) + (unit && ` [${unit}]`);
}

/** What a list holds; pairs, as bands are, say it of each place. */
const itemOf = (schema) => plain(schema.items ?? schema.prefixItems?.[0] ?? {});
const isList = (schema) => schema.type === "array" && (LISTS.has(itemOf(schema).type) || itemOf(schema).type === "string");

/** Numbers by name, as levels are: `low: 0.5, high: 1`. */
const isMap = (schema) => schema.type === "object" && LISTS.has(plain(schema.additionalProperties ?? {}).type);

function readMap(schema, text) {
  return Object.fromEntries(text.split(/[,;]+/).filter((part) => part.trim()).map((part) => {
    const [name, value] = part.split(":");
    if (value === undefined) throw new Error(`write it as name: number, such as low: 0.5`);
    return [name.trim(), numberOf(plain(schema.additionalProperties), value.trim())];
  }));
}

function written(schema, value) {
  if (value === undefined || value === null) return "";
  if (isList(schema)) return value.map((item) => (typeof item === "string" || Number.isInteger(item) ? item : Number(item.toFixed(4)))).join(", ");
  if (isMap(schema)) return Object.entries(value).map(([name, one]) => `${name}: ${one}`).join(", ");
  return typeof value === "object" ? JSON.stringify(value) : String(value);
}

/** The value that a text stands for; throws a sentence. */
function read(schema, text) {
  if (text.trim() === "") {
    if (schema.optional || schema.default !== undefined) return undefined;
    throw new Error("is needed");
  }
  if (isList(schema) && itemOf(schema).type === "string") return text.split(/[,;]/).map((item) => item.trim()).filter(Boolean);
  if (isList(schema)) return text.split(/[\s,;]+/).filter(Boolean).map((item) => numberOf(itemOf(schema), item));
  if (isMap(schema)) return readMap(schema, text);
  if (LISTS.has(schema.type)) return numberOf(schema, text);
  if (schema.type === "string" || schema.enum) return text;
  try { return JSON.parse(text); } catch { throw new Error("is no JSON"); }
}

function numberOf(schema, text) {
  const value = Number(text);
  if (!Number.isFinite(value)) throw new Error(`${text} is no number`);
  if (schema.type === "integer" && !Number.isInteger(value)) throw new Error(`${text} is no whole number`);
  if (value <= schema.exclusiveMinimum) throw new Error(`must be more than ${schema.exclusiveMinimum}`);
  if (value < schema.minimum) throw new Error(`must be at least ${schema.minimum}`);
  if (value >= schema.exclusiveMaximum) throw new Error(`must be less than ${schema.exclusiveMaximum}`);
  if (value > schema.maximum) throw new Error(`must be at most ${schema.maximum}`);
  return value;
}

/** One field: its element, and `value()`, which throws a sentence. */
function field(path, name, raw, start) {
  const schema = plain(raw);
  if (schema.properties) return group(path, name, schema, start ?? {});
  const id = `f-${path}`;
  const wrong = h("small", { class: "wrong", id: `${id}-wrong`, role: "status" });
  const given = written(schema, start ?? schema.default);
  let input;
  if (schema.enum) input = h("select", { id }, [...(schema.optional && schema.default === undefined ? [""] : []), ...schema.enum].map((one) => h("option", { value: one, selected: one === given }, one)));
  else if (schema.type === "boolean") input = h("input", { id, type: "checkbox", checked: given === "true" });
  else input = h("input", { id, value: given, autocomplete: "off", inputmode: LISTS.has(schema.type) ? "decimal" : "text", "aria-describedby": wrong.id });
  const value = () => (schema.type === "boolean" ? input.checked : read(schema, input.value));
  function check() {
    try { value(); wrong.textContent = ""; input.removeAttribute("aria-invalid"); return true; } catch (error) {
      wrong.textContent = error.message;
      input.setAttribute("aria-invalid", "true");
      return false;
    }
  }
  input.addEventListener("input", check);
  const help = schema.description ? h("small", { class: "muted" }, schema.description) : null;
  return { element: h("div", { class: "field" }, h("label", { for: id }, label(name, schema["x-unit"])), input, wrong, help), value, check };
}

function group(path, name, schema, start) {
  const fields = fieldsOf(path, schema, start);
  const used = h("input", { type: "checkbox", checked: !schema.optional || schema.default !== undefined && schema.default !== null });
  const check = () => !used.checked || fields.map(([, one]) => one.check()).every(Boolean);
  const inside = h("div", { class: "fields" }, fields.map(([, one]) => one.element));
  return { element: h("details", { class: "group" }, h("summary", {}, label(name)), schema.optional && h("label", {}, used, " used"), inside), value: () => (used.checked ? valueOf(fields) : undefined), check };
}

const fieldsOf = (path, schema, start) => Object.entries(schema.properties)
  .filter(([, one]) => one.const === undefined)
  .map(([name, one]) => [name, field(`${path}-${name}`, name, schema.required?.includes(name) ? one : { ...plain(one), optional: true }, start[name])]);

function valueOf(fields) {
  const pairs = fields.map(([name, one]) => [name, one.value()]).filter(([, value]) => value !== undefined);
  return Object.fromEntries(pairs);
}

/** Fields for the query of a POST, in the words of the API; `query()` is null where one of them cannot be used. */
export async function queryFields(path, known) {
  document_ ??= await get("/openapi.json");
  const asked = document_.paths[path].post.parameters.filter(({ name, in: place }) => place === "query" && !known.includes(name));
  const fields = fieldsOf("query", { properties: Object.fromEntries(asked.map((one) => [one.name, { ...one.schema, description: one.description }])) }, {});
  const query = () => Object.entries(valueOf(fields)).flatMap(([name, value]) => [value].flat().map((one) => [name, one]));
  return { elements: fields.map(([, one]) => one.element), query: () => (fields.map(([, one]) => one.check()).every(Boolean) ? query() : null) };
}

/** A form for a plan; the fields in `first` are shown at once, the others on request. `begin(plan)` is called at the end. */
export async function planForm({ name, kind, first, start, begin, signal }) {
  const schema = await schemaOf(name);
  const fields = fieldsOf(kind, schema, start);
  const shown = fields.filter(([field_]) => first.includes(field_));
  const others = fields.filter(([field_]) => !first.includes(field_));
  const verdict = h("p", { class: "muted", role: "status" });
  const go = h("button", { type: "submit", class: "main" }, "Begin the test");
  let timer = 0;
  const plan = () => ({ kind, ...valueOf(fields) });
  async function check() {
    if (!fields.map(([, one]) => one.check()).every(Boolean)) { put(verdict, "Some fields are not valid yet."); return false; }
    const found = await post(`rigs/${lab.rig.id}/plan-checks`, plan());
    verdict.className = found.problems.length ? "bad" : "good";
    put(verdict, found.problems.length ? found.problems.join("; ") : `The bench can run this plan: ${found.blocks} blocks, about ${duration(found.duration_s)}.`);
    return !found.problems.length;
  }
  const checkInTurn = () => check().then((good) => { go.disabled = !good; }).catch((error) => { put(verdict, error.detail); });
  const form = h("form", { class: "plan", oninput: () => { clearTimeout(timer); timer = setTimeout(checkInTurn, CHECK_MS); }, onsubmit: async (event) => {
    event.preventDefault();
    go.disabled = true;
    try { if (await check()) await begin(plan()); } catch (error) { put(verdict, error.detail ?? error.message, " ", error.remedy ?? ""); verdict.className = "bad"; } finally { go.disabled = false; }
  } }, h("div", { class: "fields" }, shown.map(([, one]) => one.element)),
  h("details", {}, h("summary", {}, "All settings"), h("div", { class: "fields" }, others.map(([, one]) => one.element))), verdict, h("p", { class: "buttons" }, go));
  signal.addEventListener("abort", () => clearTimeout(timer));
  checkInTurn();
  return form;
}
