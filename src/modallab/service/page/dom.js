/** Elements of the page, made from text and never from markup: what people typed stays text. */

const SVG = "http://www.w3.org/2000/svg";

function fill(element, properties, children) {
  for (const [name, value] of Object.entries(properties ?? {})) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "value" || name === "checked") element[name] = value;
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat(3).filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/** An element with attributes, listeners (`onclick`) and children. */
export const h = (tag, properties, ...children) => fill(document.createElement(tag), properties, children);

/** The same for drawings. */
export const svg = (tag, properties, ...children) => fill(document.createElementNS(SVG, tag), properties, children);

/** Put new children into an element that is there. */
export function put(element, ...children) {
  element.replaceChildren(...children.flat(3).filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/** Change a text only where it is another one: screen readers speak what changes. */
export function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** A titled part of a view. */
export const panel = (title, ...children) => {
  const id = `p-${title.toLowerCase().replace(/[^a-z]+/g, "-")}`;
  return h("section", { class: "panel", "aria-labelledby": id }, h("h2", { id }, title), ...children);
};

/** A table; `heads` are texts, or [text, class]; cells are texts or elements. Wide ones scroll by themselves. */
export function table(caption, heads, rows) {
  const classes = heads.map((head) => (Array.isArray(head) ? head[1] : undefined));
  const cell = (value, n) => h(n === 0 ? "th" : "td", { class: classes[n], scope: n === 0 && "row" }, value ?? "");
  return h("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
    h("table", {}, h("caption", { class: "hidden" }, caption),
      h("thead", {}, h("tr", {}, heads.map((head, n) => h("th", { scope: "col", class: classes[n] }, Array.isArray(head) ? head[0] : head)))),
      h("tbody", {}, rows.map((row) => h("tr", {}, row.map(cell))))));
}

/** Keep a canvas as wide as it is shown, in dots of the screen: its text keeps its size on a phone. */
export function fitted(canvas, height, drawn, signal) {
  const fit = () => {
    const ratio = devicePixelRatio || 1, width = canvas.clientWidth;
    if (!width) return;
    Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    canvas.style.height = `${height}px`;
    canvas.getContext("2d").setTransform(ratio, 0, 0, ratio, 0, 0);
    drawn(width);
  };
  const watcher = new ResizeObserver(fit);
  watcher.observe(canvas);
  signal.addEventListener("abort", () => watcher.disconnect());
}

/** A button that is busy while what it does goes on; errors are shown as sentences. */
export function button(text, act, properties = {}) {
  const element = h("button", { type: "button", ...properties, onclick: async () => {
    element.disabled = true;
    try { await act(); } catch (error) { show(error); } finally { element.disabled = false; }
  } }, text);
  return element;
}

/** Say what went wrong, and what to do, until it is closed. */
export function show(error) {
  // Who has left a view waits for nothing in it.
  if (error.name === "AbortError") return;
  const box = document.getElementById("messages");
  const text = error.detail ?? error.message ?? String(error);
  const remedy = error.remedy ? ` To correct it: ${error.remedy}.` : "";
  const line = h("p", { class: "message" }, h("span", {}, sentence(text), remedy),
    h("button", { type: "button", "aria-label": "Close this message", onclick: () => line.remove() }, "×"));
  for (const old of box.children) if (old.firstChild.textContent === line.firstChild.textContent) old.remove();
  box.append(line);
}

/** With a capital and a full stop. */
export function sentence(text) {
  const trimmed = text.trim();
  return trimmed.charAt(0).toUpperCase() + trimmed.slice(1) + (/[.!?:]$/.test(trimmed) ? "" : ".");
}
