// The workpiece: drawn by the server while the pointer turns it, read by a click, cut along a line; what is different
// in a box.

import { divider } from "./divider.js";
import { ask, find, make, number } from "./dom.js";
import { askMotion, paintMotion } from "./motion.js";
import { dragged, keyed, wheeled } from "./orbit.js";
import { regionTables } from "./region.js";

const view = find("view");
const WAIT = 160;
// A moving picture has as many pixels as are drawn in this time [ms], but at least this share along each side.
const MOVING = 80;
const COARSEST = 0.3;
const ABOVE = { azimuth: -90, elevation: 62, zoom: 1, right: 0, up: 0 };
const LABELS = [
  ["xMm", "x", "mm"], ["yMm", "y", "mm"], ["zMm", "z", "mm"],
  ["removedUm", "removed, of the surface that is drawn", "\u00b5m"], ["measuredRemovedUm", "removed, measured", "\u00b5m"],
  ["deviationUm", "measured \u2212 simulated", "\u00b5m"], ["deviationFloors", "the same", "noise floors"],
  ["dose", "dose", ""],
];

let address = "";
let turn = { ...ABOVE };
let busy = false;
let again = null;
let later = 0;
let coarse = 1;
let bitmap = null;
let former = null;
let split = null;
let line = null;
let box = null;
let mark = null;
let drags = "turn";
let trials = null;
let drawn = 0;

/** What is asked for, beside the size; before the first pass, or after the chosen one. */
const query = (extra, before = false) => {
  const pass = before ? 0 : +find("pass").value;
  const isPlain = before && !["photograph", "dose"].includes(find("mode").value);
  const [mode, covariate] = isPlain ? ["removed"] : find("mode").value.split(" ");
  const shown = covariate === undefined ? { mode } : { mode, covariate };
  return new URLSearchParams({ trial: find("trial").value, pass, whose: find("whose").value, ...shown, ...turn, ...extra });
};

const paint = () => {
  const context = view.getContext("2d");
  if (bitmap) context.drawImage(bitmap, 0, 0, view.width, view.height);
  if (former && split.isOn()) {
    context.save();
    context.beginPath();
    context.rect(0, 0, split.x(), view.height);
    context.clip();
    context.drawImage(former, 0, 0, view.width, view.height);
    context.restore();
  }
  paintMotion(context);
  context.lineWidth = 2;
  if (line) {
    for (const [colour, width] of [["#fff", 4], ["#1c2330", 2]]) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.beginPath();
      context.moveTo(...line[0]);
      context.lineTo(...line[1]);
      context.stroke();
    }
  }
  if (box) {
    const [[x0, y0], [x1, y1]] = box;
    for (const [colour, width] of [["#fff", 4], ["#1c2330", 2]]) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.strokeRect(Math.min(x0, x1), Math.min(y0, y1), Math.abs(x1 - x0), Math.abs(y1 - y0));
    }
  }
  if (mark) {
    context.strokeStyle = "#1c2330";
    context.strokeRect(mark[0] - 5, mark[1] - 5, 10, 10);
    context.strokeStyle = "#fff";
    context.strokeRect(mark[0] - 6, mark[1] - 6, 12, 12);
  }
};

const step = (colour) => {
  const part = make("i");
  part.style.background = colour;
  return part;
};

const showLegend = (legend) => {
  const box = find("legend");
  box.replaceChildren();
  if (!legend.title) return;
  box.append(make("div", {}, legend.title + (legend.unit ? ` [${legend.unit}]` : "")));
  if (legend.keys) {
    for (const key of legend.keys) box.append(make("span", { className: "key" }, step(key.colour), ` ${key.words} `));
    box.classList.add("legend");
    return;
  }
  box.append(make("div", { className: "steps" }, ...(legend.colours || legend.ramp).map(step)));
  const ends = legend.ramp ? [legend.least, (legend.least + legend.most) / 2, legend.most]
    : [...legend.bounds.map((b) => -b).reverse(), 0, ...legend.bounds];
  const shown = ends.length > 9 ? ends.filter((_, k) => k % 2 === (ends.length - 1) / 2 % 2) : ends;
  box.append(make("div", { className: "ends" }, ...shown.map((value) => make("span", {}, number(value, 2)))));
};

/** Draws the same view of the other model. */
const paintOther = async (size) => {
  const other = find("other");
  if (other.hidden) return;
  const answer = await ask(`${address}/frame?${query({ ...size, model: find("beside").value })}`);
  other.getContext("2d").drawImage(await createImageBitmap(await answer.blob()), 0, 0, other.width, other.height);
  other.dataset.model = find("beside").value;
};

/** Lists the models that can be drawn beside the current one. */
const showBeside = (state) => {
  const select = find("beside");
  const own = select.value;
  const models = state.stages.filter((stage) => state.drawable.includes(stage.number) && stage.number !== state.current);
  const options = models.map((stage) => make("option", { value: stage.number }, `model ${stage.number}: ${stage.label}`));
  select.replaceChildren(make("option", { value: "" }, "nothing"), ...options);
  select.value = models.some((stage) => String(stage.number) === own) ? own : "";
  setBeside();
};

const setBeside = () => {
  const two = find("beside").value !== "";
  find("other").hidden = !two;
  find("views").classList.toggle("two", two);
};

/** Draws one picture; while it is made, only the last wish waits. */
const draw = async (fine) => {
  if (!address || !trials) return;
  if (busy) {
    again = fine;
    return;
  }
  busy = true;
  const since = performance.now();
  const scale = fine ? 1 : coarse;
  const size = { width: Math.round(view.width * scale), height: Math.round(view.height * scale), fine };
  try {
    const whole = query({ width: view.width, height: view.height, fine });
    const earlier = split.isOn() ? ask(`${address}/frame?${query(size, true)}`) : null;
    const [answer, first] = await Promise.all([ask(`${address}/frame?${query(size)}`), earlier, askMotion(address, whole)]);
    showLegend(JSON.parse(answer.headers.get("x-legend")));
    bitmap = await createImageBitmap(await answer.blob());
    former = first && await createImageBitmap(await first.blob());
    view.dataset.divided = Boolean(former);
    paint();
    await paintOther(size);
    drawn += 1;
    view.dataset.frames = drawn;
    view.dataset.milliseconds = Math.round(performance.now() - since);
    view.dataset.fine = fine;
    if (!fine) {
      view.dataset.scale = scale;
      const wanted = scale * Math.sqrt(MOVING / (performance.now() - since));
      coarse = Math.min(1, Math.max(COARSEST, (coarse + wanted) / 2));
    }
  } catch (error) {
    find("legend").replaceChildren(make("p", {}, error.message));
  }
  busy = false;
  if (again !== null) {
    const wish = again;
    again = null;
    draw(wish);
  }
};

const move = () => {
  line = box = mark = null;
  draw(false);
  clearTimeout(later);
  later = setTimeout(() => draw(true), WAIT);
};

const placeOf = (event) => {
  const box = view.getBoundingClientRect();
  const scale = view.width / box.width;
  return [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale];
};

const probe = async ([x, y]) => {
  const pixel = { x: Math.round(x - 0.5), y: Math.round(y - 0.5), width: view.width, height: view.height, fine: false };
  return (await ask(`${address}/probe?${query(pixel, split.isOn() && x < split.x())}`)).json();
};

const read = async (place) => {
  mark = place;
  paint();
  const list = find("reading");
  try {
    const values = await probe(place);
    const known = LABELS.filter(([key]) => values[key] !== null && values[key] !== undefined);
    const cell = ([key, words, unit]) => make("div", {}, make("dt", {}, words),
      make("dd", { "data-key": key, "data-value": values[key] }, `${number(values[key])} ${unit}`));
    list.replaceChildren(...known.map(cell));
  } catch (error) {
    list.replaceChildren(make("dt", {}, error.message));
  }
};

/** What the server says of two places [mm], which the form then shows. */
const between = async (what, ends) => {
  const form = find("line");
  for (const [name, value] of Object.entries(ends)) form.elements[name].value = (+value).toFixed(3);
  const size = { width: view.width, height: view.height, fine: false };
  return (await ask(`${address}/${what}?${query({ ...size, ...ends })}`)).json();
};

/** Cuts along a line between two places. */
const cut = async (ends) => {
  const figure = find("section");
  try {
    const made = await between("section", ends);
    figure.innerHTML = made.svg;
    const words = `${made.words}: ${number(made.rmsUm)} \u00b5m root mean square is left, noise floor ${number(made.floorUm)} \u00b5m.`;
    figure.append(make("figcaption", { "data-rms": made.rmsUm }, words));
  } catch (error) {
    figure.replaceChildren(make("figcaption", {}, error.message));
  }
};

/** Shows what is different in the box between two places. */
const lookAt = async (ends) => {
  try {
    find("region").replaceChildren(...regionTables(await between("region", ends), trials));
  } catch (error) {
    find("region").replaceChildren(make("p", {}, error.message));
  }
};

/** Does something with the places that two pixels show. */
const withPlaces = async ([from, to], act, output) => {
  try {
    const [a, b] = await Promise.all([probe(from), probe(to)]);
    await act({ x0: a.xMm, y0: a.yMm, x1: b.xMm, y1: b.yMm });
  } catch (error) {
    find(output).replaceChildren(make("p", {}, error.message));
  }
};

const drag = (start) => {
  const from = placeOf(start);
  const begun = { ...turn };
  let moved = false;
  const follow = (event) => {
    const [x, y] = placeOf(event);
    const [dx, dy] = [x - from[0], y - from[1]];
    moved = moved || Math.hypot(dx, dy) > 4;
    if (!moved) return;
    if (drags !== "turn") {
      if (drags === "cut") line = [from, [x, y]];
      else box = [from, [x, y]];
      paint();
    } else {
      turn = dragged(begun, [dx, dy], view.height, start.shiftKey || start.button === 2);
      move();
    }
  };
  const end = (event) => {
    view.removeEventListener("pointermove", follow);
    if (event.type !== "pointerup") return;
    if (!moved) read(from);
    else if (drags === "cut" && line) withPlaces(line, cut, "section");
    else if (drags === "mark" && box) withPlaces(box, lookAt, "region");
  };
  view.setPointerCapture(start.pointerId);
  view.addEventListener("pointermove", follow);
  view.addEventListener("pointerup", end, { once: true });
  view.addEventListener("pointercancel", end, { once: true });
};

const press = (event) => {
  if (event.key === "Enter") return read([view.width / 2, view.height / 2]);
  const to = event.ctrlKey || event.metaKey ? null : keyed(turn, event.key, ABOVE);
  if (!to) return undefined;
  event.preventDefault();
  turn = to;
  return move();
};

const setDrag = (to) => {
  drags = to;
  for (const id of ["turn", "cut", "mark"]) find(id).setAttribute("aria-pressed", id === to);
  view.classList.toggle("cutting", to !== "turn");
};

const showPasses = () => {
  const { passes } = trials[+find("trial").value];
  const words = (pass, k) => `pass ${k + 1}${pass.isFitted ? "" : ", held out"}`;
  const options = passes.map((pass, k) => make("option", { value: k + 1 }, words(pass, k)));
  find("pass").replaceChildren(...options);
  find("pass").value = passes.length;
};

/** Shows the trials of a state once, and draws again when another model is the current one. */
export const show = (state) => {
  if (!view || !state.trials) return;
  if (!trials) {
    trials = state.trials;
    find("trial").replaceChildren(...trials.map((trial, k) => make("option", { value: k }, trial.name)));
    showPasses();
    if (trials[0].passes.every((pass) => pass.isHeights)) find("mode").querySelector("[value=dose]").remove();
    if (!state.isLive) find("whose").value = "measured";
  }
  if (state.isLive && find("whose").dataset.kept !== "yes") find("whose").value = "simulated";
  showBeside(state);
  const shown = `${state.current} ${state.isLive}`;
  if (view.dataset.shown !== shown) {
    view.dataset.shown = shown;
    move();
  }
};

/** Begins to listen. */
export const listen = (to) => {
  address = to;
  if (!view) return;
  view.addEventListener("pointerdown", drag);
  view.addEventListener("contextmenu", (event) => event.preventDefault());
  view.addEventListener("keydown", press);
  view.addEventListener("wheel", (event) => {
    event.preventDefault();
    turn = wheeled(turn, event.deltaY);
    move();
  }, { passive: false });
  find("trial").addEventListener("change", () => { showPasses(); move(); });
  for (const id of ["pass", "mode", "whose"]) find(id).addEventListener("change", move);
  find("whose").addEventListener("change", () => { find("whose").dataset.kept = "yes"; });
  find("beside").addEventListener("change", () => { setBeside(); move(); });
  for (const id of ["turn", "cut", "mark"]) find(id).addEventListener("click", () => setDrag(id));
  find("reset").addEventListener("click", () => { turn = { ...ABOVE }; move(); });
  find("moment").addEventListener("input", paint);
  find("way").addEventListener("click", () => {
    find("way").setAttribute("aria-pressed", find("way").getAttribute("aria-pressed") !== "true");
    move();
  });
  split = divider(view, find("divider"), paint);
  find("before").addEventListener("click", () => {
    split.show(!split.isOn());
    find("before").setAttribute("aria-pressed", split.isOn());
    move();
  });
  find("line").addEventListener("submit", (event) => {
    event.preventDefault();
    const act = event.submitter?.value === "region" ? lookAt : cut;
    act(Object.fromEntries(new FormData(event.target)));
  });
};
