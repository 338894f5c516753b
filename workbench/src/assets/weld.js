// A weld on a part: dials, a picture that follows them, figures, and the asset made in the background.

import { ask, find, make, number } from "./dom.js";
import { orbit } from "./orbit.js";

const view = find("view");
const dials = find("dials");
const REST = 180;
const RETRY = 2000;
// Seen from the front right above.
const HOME = { azimuth: -58, elevation: 32, zoom: 1, right: 0, up: 0 };
const FIGURES = [
  ["lengthMm", "length", "mm"], ["widthMm", "width", "mm"], ["heightMm", "height", "mm"],
  ["curvatureRms", "curvature, RMS", "1/m"], ["curvatureMax", "curvature, maximum", "1/m"],
  ["exposure", "exposure, least", ""], ["access", "access, mean", ""], ["volumeMm3", "bead volume", "mm\u00b3"],
  ["defects", "imperfections", ""],
];

let busy = false;
let again = null;
let later = 0;
let drawn = 0;
let moved = 0;
let since = 0;
let named = false;

const rows = () => [...dials.querySelectorAll(".dial")];
const fields = (row) => [...row.querySelectorAll(".field")];
const part = () => find("part-file").selectedOptions[0];

/** The flags that are set, by name. */
const flags = () => {
  const set = {};
  for (const input of dials.querySelectorAll("[name]")) if (input.value !== "") set[input.name] = input.value;
  for (const row of rows()) {
    const [low, high] = fields(row).map((field) => field.value);
    if (low || high) set[row.dataset.name] = high !== undefined && low !== high ? `${low || high}..${high || low}` : low;
  }
  return set;
};

const query = (more) => new URLSearchParams({ ...flags(), ...more });
const address = (what, more) => `/weld/parts/${part().value}/${what}?${query(more)}`;

const showFigures = (found) => {
  const { welds, failure } = found;
  const words = find("failure");
  words.textContent = failure ? `No weld: ${failure.replace(/\.$/, "")}.` : `Difficulty of the finished weld: ${found.difficulty}.`;
  words.className = failure ? "bad" : "";
  view.dataset.failure = failure ?? "";
  const figure = (weld, key, unit) => make("td", { "className": "n", "data-key": key, "data-value": weld[key] }, `${number(weld[key])} ${unit}`);
  const head = welds.length > 1 ? [make("tr", {}, make("th", {}), ...welds.map((_, k) => make("th", { scope: "col", className: "n" }, `weld ${k + 1}`)))] : [];
  const lines = FIGURES.map(([key, name, unit]) => make("tr", {}, make("th", { scope: "row" }, name), ...welds.map((weld) => figure(weld, key, unit))));
  find("figures").replaceChildren(...(welds.length ? [...head, ...lines] : []));
  const remarks = [...found.warnings, ...(found.reasons ?? [])];
  find("remarks").replaceChildren(...remarks.map((remark) => make("li", {}, remark)));
  const size = found.sizeMm.map((side) => number(side, 3)).join(" \u00d7 ");
  find("about").textContent = `${size} mm, ${number(found.triangles)} triangles. ${found.notes.join("; ")}`;
  find("command").textContent = found.command ?? "";
  find("name-fault").textContent = found.nameFault ?? "";
  showRanges(found.dials);
};

/** Gives each slider its range on this part, and shows in grey what is chosen where nothing is set. */
const showRanges = (ranges) => {
  for (const row of rows()) {
    const { least, most, chosen } = ranges[row.dataset.name.slice(2)];
    const slider = row.querySelector("[type=range]");
    const set = fields(row)[0].value;
    Object.assign(slider, { min: least, max: most });
    if (!row.contains(document.activeElement)) slider.value = set || (chosen ? chosen[0] : least);
    slider.setAttribute("aria-valuetext", set || (chosen ? `chosen: ${number(chosen[0], 3)}` : "not set"));
    for (const [k, field] of fields(row).entries()) field.placeholder = chosen ? number(chosen[k], 3) : "";
  }
};

/** Asks for figures and picture; while they are made, only the last wish waits. */
const draw = async (fine) => {
  if (busy) {
    again = fine;
    return;
  }
  busy = true;
  const asked = moved;
  const begun = performance.now();
  const scale = fine ? 1 : 0.6;
  const size = { width: Math.round(view.width * scale), height: Math.round(view.height * scale), fine };
  try {
    showFigures(await (await ask(address("figures", { name: find("name").value }))).json());
    const answer = await ask(address("picture", { ...camera.turn(), ...size }));
    view.getContext("2d").drawImage(await createImageBitmap(await answer.blob()), 0, 0, view.width, view.height);
    find("fault").hidden = true;
    drawn += 1;
    Object.assign(view.dataset, { frames: drawn, fine, asked });
    if (!fine) view.dataset.milliseconds = Math.round(performance.now() - begun);
  } catch (error) {
    find("fault").hidden = false;
    find("fault").textContent = error.message;
    view.dataset.asked = asked;
  }
  busy = false;
  if (again !== null) {
    const wish = again;
    again = null;
    draw(wish);
  }
};

const look = () => {
  moved += 1;
  draw(false);
  clearTimeout(later);
  later = setTimeout(() => draw(true), REST);
};

const camera = orbit(view, HOME, look);

const choosePart = () => {
  named = false;
  name();
  view.getContext("2d").clearRect(0, 0, view.width, view.height);
  history.replaceState(null, "", `#${part().value}`);
  camera.reset();
};

/** Proposes a name for the asset until the user types one. */
const name = () => {
  if (!named) find("name").value = `${part().dataset.stem}-${dials.elements["--seed"].value}`;
};

const turned = (event) => {
  const row = event.target.closest(".dial");
  if (row && event.target.type === "range") {
    const value = row.dataset.count ? event.target.value : String(+(+event.target.value).toPrecision(4));
    for (const field of fields(row)) field.value = value;
  } else if (row) {
    // The end that is typed moves the other one along.
    const [low, high] = fields(row);
    if (high?.value && low.value && +low.value > +high.value) (event.target === low ? high : low).value = event.target.value;
  }
  name();
  look();
};

const post = async (to, body) => {
  const headers = { "content-type": "application/json" };
  try {
    await ask(to, { method: "POST", headers, body: JSON.stringify(body) });
    find("outcome").textContent = "";
  } catch (error) {
    find("outcome").className = "bad";
    find("outcome").textContent = error.message;
  }
};

const showRun = ({ version, run, address: to }) => {
  since = version;
  if (!run) return;
  const runs = run.outcome === null;
  find("progress").hidden = !runs;
  find("cancel").hidden = !runs;
  find("lines").hidden = false;
  find("lines").textContent = `${run.command}\n${run.lines.join("\n")}`;
  find("work").textContent = runs ? `making ${run.out}` : "";
  const outcome = find("outcome");
  outcome.replaceChildren();
  outcome.dataset.is = runs ? "runs" : run.outcome.failed ? "failed" : run.outcome;
  outcome.className = run.outcome?.failed ? "bad" : "";
  if (run.outcome === "made") {
    outcome.append(`Made in ${number(run.seconds, 3)} s: ${run.out}`, ...(to ? [" ", make("a", { href: to }, "its picture")] : []));
  } else if (run.outcome === "cancelled") {
    outcome.append("Cancelled; nothing is left of it.");
  } else if (run.outcome) {
    outcome.append(run.outcome.failed);
  }
};

const follow = async () => {
  for (;;) {
    try {
      showRun(await (await ask(`/weld/run?since=${since}`)).json());
    } catch {
      find("work").textContent = "The server does not answer.";
      await new Promise((done) => { setTimeout(done, RETRY); });
    }
  }
};

dials.addEventListener("input", turned);
dials.addEventListener("submit", (event) => event.preventDefault());
find("next").addEventListener("click", () => {
  dials.elements["--seed"].value = +dials.elements["--seed"].value + 1;
  name();
  look();
});
find("clear").addEventListener("click", () => {
  dials.reset();
  name();
  look();
});
find("name").addEventListener("input", () => { named = true; look(); });
find("part-file").addEventListener("change", choosePart);
find("make").addEventListener("submit", (event) => {
  event.preventDefault();
  post("/weld/run", { part: part().value, name: find("name").value, flags: flags() });
});
find("cancel").addEventListener("click", () => post("/weld/cancel", {}));
const wanted = location.hash.slice(1);
if ([...find("part-file").options].some((option) => option.value === wanted)) find("part-file").value = wanted;
choosePart();
follow();
