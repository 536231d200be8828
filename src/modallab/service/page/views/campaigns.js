/** Campaigns: what was recorded, two runs beside each other, files in and out, reports. */

import { all, ask, find, get, post } from "../api.js";
import { Chart, look, positive } from "../charts.js";
import { button, h, panel, put, show as showError, table } from "../dom.js";
import { queryFields } from "../forms.js";
import { lab } from "../lab.js";
import { waitForJob } from "../jobs.js";
import { clock, number, percent } from "../numbers.js";

const FORMATS = ["hdf5", "uff", "tdms"];
/** Runs to compare, the last two that were checked, of whichever campaigns. */
let chosen = [];

export async function show(view, signal) {
  const [list, detail, compared] = [h("div"), h("div"), h("div")];
  const text = h("input", { id: "search", type: "search", oninput: () => fill().catch(showError) });
  put(view, h("h1", {}, "Campaigns"), panel("Recorded", h("div", { class: "field" }, h("label", { for: "search" }, "Search by name or note"), text), list, importer(fill)), detail, compared);

  async function fill() {
    const found = (await get(`campaigns?limit=50&text=${encodeURIComponent(text.value)}`)).items;
    put(list, found.length ? table("Campaigns", ["Name", "Begun", "By", "Rig", ["Runs", "n"], ""], found.map((one) => [
      one.name, clock(one.created_utc), one.operator, one.rig, one.runs.length, button("Open", () => open(one.id), { "aria-label": `Open ${one.name}` })])) : h("p", { class: "muted" }, "There is no campaign. Begin a test, or drop a file."));
  }

  async function open(id) {
    const campaign = await get(`campaigns/${id}`);
    const runs = await all(`campaigns/${id}/runs`);
    const said = h("span", { class: "muted", role: "status" });
    const check = (run, checked) => {
      chosen = [...chosen.filter((one) => one !== run), ...(checked ? [run] : [])].slice(-2);
      boxes.forEach((box) => { box.checked = chosen.includes(box.value); });
      said.textContent = chosen.length ? `Chosen: ${chosen.join(" and ")}` : "Check two runs, of this campaign or another.";
    };
    const boxes = runs.map((run) => h("input", { type: "checkbox", value: run.id, "aria-label": `Compare ${run.id}`, onchange: ({ target }) => check(run.id, target.checked) }));
    const format = h("select", { "aria-label": "Format of the file" }, FORMATS.map((one) => h("option", {}, one)));
    put(compared);
    put(detail, panel(campaign.name, campaign.note && h("p", {}, campaign.note),
      table("Runs", ["", "Run", "Test", "State", ["Good blocks", "n"], ["Rate", "n"], "By", "Why"], runs.map((run, n) => [boxes[n], run.id, run.test, `${run.state}${run.valid ? "" : ", invalid"}`, `${run.accepted} of ${run.blocks}`, run.rate_hz ? `${number(run.rate_hz, 4)} Hz` : "–", run.operator, run.reason])),
      h("p", { class: "buttons" }, button("Compare two runs", async () => {
        if (chosen.length !== 2) throw new Error("Two runs are needed: choose them in the table, of this campaign or another.");
        await compare(compared, chosen, signal);
      }), said, h("a", { href: `#/model/${id}` }, "Model"), h("a", { href: `#/gap/${id}` }, "Gap"), format,
      button("Export", () => save(`campaigns/${id}/export?to=${format.value}`, id)),
      button("Report", () => report(id)))));
    check();
    detail.scrollIntoView({ block: "nearest" });
  }
  await fill();
}

/** The newest report, made first if there is none. */
async function report(id) {
  const window_ = open("about:blank");
  try {
    const job = await post(`campaigns/${id}/reports`);
    await waitForJob(job.id);
    window_.location = `/api/v1/campaigns/${id}/report`;
  } catch (error) {
    window_.close();
    throw error;
  }
}

async function save(path, name) {
  const response = await ask("GET", path, { patience: 300000 });
  const file = /filename="?([^"]+)"?/.exec(response.headers.get("content-disposition") ?? "")?.[1] ?? name;
  const link = h("a", { href: URL.createObjectURL(await response.blob()), download: file });
  link.click();
  URL.revokeObjectURL(link.href);
}

const ENDINGS = { csv: ".csv .txt .tsv .dat .asc", hdf5: ".h5 .hdf5", hdf5_arrays: ".hdf", lvm: ".lvm", mat: ".mat", netcdf: ".nc .nc4", npy: ".npy .npz", sep005: ".json", tdms: ".tdms", uff: ".uff .unv .bunv .uf", wav: ".wav" };
const FORMAT_OF = Object.fromEntries(Object.entries(ENDINGS).flatMap(([format, endings]) => endings.split(" ").map((ending) => [ending, format])));

/** Files of others, dropped or chosen. */
function importer(done) {
  const said = h("p", { class: "muted", role: "status" }, `Drop a file here, or choose one: ${Object.keys(FORMAT_OF).join(", ")}.`);
  const input = h("input", { type: "file", id: "file", accept: Object.keys(FORMAT_OF).join(","), onchange: () => take(input.files) });
  let asked = null;
  const fields = h("div", { class: "fields" });
  const about = h("details", { ontoggle: async () => {
    if (asked) return;
    try { put(fields, (asked = await queryFields("/api/v1/imports", ["name", "rig", "format"])).elements); } catch (error) { showError(error); }
  } }, h("summary", {}, "Facts missing in the files"), fields);
  const place = h("div", { class: "drop" }, said, h("label", { for: "file", class: "hidden" }, "File to import"), input, about);
  async function take(files) {
    const more = asked ? asked.query() : [];
    if (!more) { said.textContent = "Some fields are not valid yet."; return; }
    for (const file of files) {
      said.textContent = `${file.name} is being read …`;
      const format = FORMAT_OF[/\.[^.]*$/.exec(file.name.toLowerCase())?.[0]] ?? "hdf5";
      const query = new URLSearchParams([["name", file.name], ["rig", lab.rig.id], ["format", format], ...more]);
      try {
        await ask("POST", `imports?${query}`, { body: file, headers: { "Content-Type": "application/octet-stream" }, patience: 600000 });
        said.textContent = `${file.name} is there.`;
      } catch (error) { said.textContent = `${file.name} was not taken.`; showError(error); }
    }
    await done();
  }
  place.addEventListener("dragover", (event) => { event.preventDefault(); place.classList.add("over"); });
  place.addEventListener("dragleave", () => place.classList.remove("over"));
  place.addEventListener("drop", (event) => { event.preventDefault(); place.classList.remove("over"); take(event.dataTransfer.files); });
  return place;
}

/** FRFs of two runs over each other, and their models side by side. */
async function compare(place, [one, other], signal) {
  const views = await Promise.all([one, other].map((run) => get(`runs/${run}`)));
  const frfs = await Promise.all(views.map((run) => (run.accepted ? find(`runs/${run.id}/frf`) : null)));
  const outputs = frfs[0]?.outputs ?? [];
  const choice = h("select", { id: "compared-output", onchange: draw }, outputs.map((name) => h("option", {}, name)));
  const chart = new Chart({ name: "Mobility of both runs", x: "Frequency [Hz]", y: "Mobility [m/(N s)]", log: true });
  signal.addEventListener("abort", () => chart.close());
  function draw() {
    const lines = [...new Set(frfs.flatMap((frf) => frf?.frequency_hz ?? []))].sort((a, b) => a - b);
    const values = frfs.map((frf) => {
      const row = frf?.outputs.indexOf(choice.value) ?? -1;
      if (row < 0) return lines.map(() => null);
      const at = new Map(frf.frequency_hz.map((hz, n) => [hz, Math.hypot(frf.values.re[row][0][n], frf.values.im[row][0][n])]));
      return positive(lines.map((hz) => at.get(hz) ?? null));
    });
    chart.draw(views.map((run, n) => ({ label: `${run.test} ${run.id}`, spanGaps: true, ...look(n) })), [lines, ...values]);
  }
  const jobs = await Promise.all(views.map((run) => get(`runs/${run.id}/jobs`)));
  const models = jobs.every(({ items }) => items.some(({ kind, state }) => kind === "identify" && state === "done"));
  const found = models ? await find(`comparison?one=${one}&other=${other}`) : null;
  const alone = (found?.alone ?? []).flatMap((places, n) => places.map((mode) => `mode ${mode + 1} of the ${["first", "second"][n]}`));
  put(place, panel("Compared", h("p", { class: "buttons" }, h("label", { for: "compared-output" }, "Output"), choice), chart.element,
    found ? table("Modes of both runs", [["Mode", "n"], ["First [Hz]", "n"], ["Second [Hz]", "n"], ["Difference", "n"], ["Sigmas", "n"], ["Damping, first", "n"], ["Damping, second", "n"], ["MAC", "n"]],
      found.modes.map(([mode], n) => [mode + 1, number(found.frequency_hz[n][0], 6), number(found.frequency_hz[n][1], 6), `${number(found.difference_percent[n], 2)} %`, number(found.sigmas[n], 2), percent(found.damping_ratio[n][0]), percent(found.damping_ratio[n][1]), number(found.mac?.[n], 4)]))
      : h("p", { class: "muted" }, "One of the runs has no model yet: the modes cannot be compared."),
    alone.length ? h("p", { class: "muted" }, `Without a partner in the other run: ${alone.join(", ")}.`) : null));
  draw();
}
