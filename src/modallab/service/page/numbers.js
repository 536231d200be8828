/** Numbers as people read them: with their unit, and not more digits than mean something. */

/** A number with `digits` significant ones; a dash where it is not known. */
export function number(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-4) return minus(value.toExponential(digits - 1).replace(/e(.*)$/, (_, power) => `·10${raised(power)}`));
  return minus(value.toFixed(Math.max(0, digits - 1 - Math.floor(Math.log10(size)))));
}

const minus = (text) => text.replace(/^-/, "−");

const raised = (power) => [...power].map((one) => (one === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[one] ?? "")).join("");

/** A number in its unit, never another one by a prefix: what stands in one column can be compared. */
export const quantity = (value, symbol, digits = 3) => (Number.isFinite(value) ? `${number(value, digits)} ${unit(symbol)}` : "–");

/** A value with its standard deviation, as 4.80(3). */
export function uncertain(value, sigma) {
  if (!Number.isFinite(value)) return "–";
  if (!Number.isFinite(sigma) || sigma <= 0) return number(value, 6);
  let digits = -Math.floor(Math.log10(sigma));
  let last = Math.round(sigma * 10 ** digits);
  // One digit of 1 or 2 says too little.
  if (last < 3) { digits += 1; last = Math.round(sigma * 10 ** digits); }
  if (digits <= 0) return minus(`${value.toFixed(0)}(${Math.round(sigma)})`);
  return minus(`${value.toFixed(Math.min(digits, 15))}(${last})`);
}

export const percent = (value, digits = 3) => (Number.isFinite(value) ? `${number(100 * value, digits)} %` : "–");

/** A time of the service as this machine's clock shows it. */
export function clock(utc) {
  const time = new Date(utc);
  return Number.isNaN(time.getTime()) ? "–" : time.toLocaleString(undefined, { dateStyle: "medium", timeStyle: "short" });
}

/** Seconds as a person says them. */
export function duration(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  if (seconds < 90) return `${Math.max(0, Math.round(seconds))} s`;
  return seconds < 5400 ? `${Math.round(seconds / 60)} min` : `${(seconds / 3600).toFixed(1)} h`;
}

const NAMES = { "m/s^2": "m/s²", "m/(N s)": "m/(N s)" };
export const unit = (text) => NAMES[text] ?? text;
