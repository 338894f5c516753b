// Models, suspects, sliders, what is held, the command lines: filled from the state of the server.

import { ask, find, make, number } from "./dom.js";

let give = () => {};
let sectionsOf = "";
let slidersOf = "";
let libraryOf = "";
let address = "";

const percent = (share) => `${number(100 * share, 3)} %`;

const glance = (words, value, of) => make("div", {}, make("dt", {}, words), make("dd", {}, value),
  make("dd", { className: "of" }, of));

const showModel = (state) => {
  const current = state.stages.find((stage) => stage.number === state.current);
  const box = find("errors");
  if (!current) {
    box.replaceChildren(make("div", {}, make("dt", {}, "not fitted yet")));
  } else {
    const { errors } = current;
    const floors = `${number(errors.calibration / errors.floor, 3)} times the noise floor of ${number(errors.floor, 3)} ${errors.unit}`;
    const cells = [glance("left in the passes that were fitted", `${number(errors.calibration)} ${errors.unit}`, floors)];
    cells[0].id = "error";
    cells[0].dataset.value = errors.calibration;
    if (errors.held_out !== null) {
      cells.push(glance("left in held-out passes", `${number(errors.held_out)} ${errors.unit}`, "no fit saw them"));
    }
    cells.push(glance("\u03c7\u00b2", number(errors.chi2, 5), `at ${number(errors.degrees_of_freedom)} degrees of freedom`));
    box.replaceChildren(...cells);
  }
  find("undo").disabled = !state.canUndo;
  find("redo").disabled = !state.canRedo;
  const report = find("report");
  report.hidden = !current;
  if (current) report.href = `${address}/stage/${current.number}/report.html`;
};

const showStages = (state) => {
  const item = (stage) => {
    const before = state.stages.find((other) => other.number === stage.before);
    const fall = before ? `, \u0394\u03c7\u00b2 ${number(before.errors.chi2 - stage.errors.chi2, 3)}` : "";
    const held = stage.errors.held_out === null ? "" : `, held out ${number(stage.errors.held_out)} ${stage.errors.unit}`;
    const figures = ` ${number(stage.errors.calibration)} ${stage.errors.unit}${held}${fall}`;
    const go = make("button", { type: "button" }, stage.label);
    go.addEventListener("click", () => give({ task: "go-to", number: stage.number }));
    const line = make("li", { value: stage.number }, go, make("span", { className: "figures" }, figures));
    if (stage.number === state.current) {
      line.setAttribute("aria-current", "true");
      for (const effect of stage.effects) {
        const out = make("button", { type: "button", title: `Take ${effect} out and fit again` }, `\u2212 ${effect}`);
        out.addEventListener("click", () => give({ task: "remove", effect }));
        line.append(" ", out);
      }
    }
    return line;
  };
  find("stages").replaceChildren(...state.stages.map(item));
  const lines = state.stages.map((stage) => `# ${stage.number}: ${stage.label}\n${stage.commands.join("\n")}`);
  find("commands").textContent = lines.join("\n\n");
  find("replay").href = `${address}/replay.sh`;
};

const suspectRow = (row, unit) => {
  const add = make("button", { type: "button", "aria-label": `Add ${row.name} and fit` }, "Add");
  add.addEventListener("click", () => give({ task: "add", effect: row.name }));
  const figure = (text) => make("td", { className: "n" }, text);
  const errors = row.evaluation_rms_before === null ? ""
    : `${number(row.evaluation_rms_before)} \u2192 ${number(row.evaluation_rms_after)} ${unit}`;
  const alike = row.indistinguishable_from.join(", ");
  const note = row.ruled_out || (alike && `indistinguishable from ${alike}`) || "";
  return make("tr", { className: row.ruled_out ? "out" : "" }, make("th", { scope: "row", title: row.title }, row.name),
    figure(percent(row.probability)), figure(number(row.delta_chi2, 3)), figure(errors), make("td", {}, note), make("td", {}, add));
};

const showSuspects = (state) => {
  const { suspects } = state;
  if (!suspects) return;
  find("suspects-words").textContent = `${suspects.sentence} (${suspects.source}; probability of none of the library: ${percent(suspects.none)})`;
  const heading = (text, isNumber) => make("th", { scope: "col", className: isNumber ? "n" : "" }, text);
  const head = make("thead", {}, make("tr", {}, heading("effect"), heading("probability", true), heading("\u0394\u03c7\u00b2", true),
    heading("held out", true), heading("note"), heading("")));
  const rows = suspects.rows.map((row) => suspectRow(row, suspects.unit));
  find("suspects").replaceChildren(head, make("tbody", {}, ...rows));
  const { plan } = suspects;
  find("next-trial").hidden = !plan;
  if (plan) {
    const files = plan.address ? [" ", make("a", { href: plan.address, download: "next-trial.zip" }, "Its files"), "."] : [];
    find("next-trial").replaceChildren(`The next trial: ${plan.summary}`, ...files);
  }
};

const showLibrary = (state) => {
  const key = JSON.stringify(state.library);
  if (!state.library || key === libraryOf) return;
  libraryOf = key;
  const option = ([name, title]) => make("option", { value: name }, `${name}: ${title}`);
  find("effect").replaceChildren(...state.library.map(option));
};

const slider = (own) => {
  const to = (value) => (own.is_log ? Math.log(value) : value);
  const back = (at) => (own.is_log ? Math.exp(at) : at);
  const [least, greatest] = own.range.map(to);
  const shown = make("output", {}, `${number(own.value)} ${own.unit}`);
  const name = `slider-${own.name}`;
  const input = make("input", { type: "range", id: name, min: least, max: greatest, step: "any", value: to(own.value) });
  const words = (value) => `${number(value)} ${own.unit}`;
  input.setAttribute("aria-valuetext", words(own.value));
  input.addEventListener("input", () => {
    const value = back(+input.value);
    shown.textContent = words(value);
    input.setAttribute("aria-valuetext", words(value));
    give({ task: "hold", parameter: own.name, value });
  });
  return make("div", { className: "slider" }, make("label", { htmlFor: name }, own.name), shown, input);
};

const showSliders = (state) => {
  const key = `${state.current} ${JSON.stringify(state.sliders)}`;
  if (!state.sliders || key === slidersOf) return;
  slidersOf = key;
  find("sliders").replaceChildren(...state.sliders.map(slider));
};

const showHeld = (state) => {
  const { held } = state;
  find("held").hidden = !held;
  if (!held) return;
  const [chi2, best] = held.chi2;
  const rms = held.rms === null ? "the fine lattice is being asked" : `${number(held.rms)} ${state.stages[0].errors.unit} is left`;
  const words = find("held-words");
  words.textContent = `${held.parameter} = ${number(held.value)}: \u03c7\u00b2 ${number(chi2, 5)}, ${number(chi2 - best, 3)} above the fit; ${rms} (${held.seconds.toFixed(2)} s).`;
  words.dataset.seconds = held.seconds;
  words.dataset.isFine = held.rms !== null;
  if (held.rms === null) words.dataset.coarse = held.seconds;
  const row = ([name, value]) => make("tr", {}, make("th", { scope: "row" }, name), make("td", { className: "n" }, value));
  find("held-others").replaceChildren(...held.others.map(row));
  find("keep").onclick = () => give({ task: "keep", parameter: held.parameter, value: held.value });
};

const showSections = async (state) => {
  const key = `${state.current}`;
  if (!state.current || key === sectionsOf) return;
  sectionsOf = key;
  const sections = await (await ask(`${address}/stage/${state.current}/sections`)).json();
  for (const name of ["waterfall", "failures", "parameters", "method"]) find(`panel-${name}`).innerHTML = sections[name];
};

/** Shows a state. */
export const show = (state) => {
  showModel(state);
  showStages(state);
  showSuspects(state);
  showLibrary(state);
  showSliders(state);
  showHeld(state);
  return showSections(state);
};

let checking = 0;

/** Says what is wrong with a formula while it is typed. */
const checkFormula = () => {
  clearTimeout(checking);
  checking = setTimeout(async () => {
    const line = find("formula-line").value.trim();
    const button = find("own").querySelector("button");
    const words = find("formula-words");
    button.disabled = true;
    words.className = "";
    if (!line) return;
    try {
      const said = await (await ask(`${address}/formula?${new URLSearchParams({ line })}`)).json();
      button.disabled = Boolean(said.fault);
      words.className = said.fault ? "bad" : "good";
      words.textContent = said.fault || `Units agree. Fitted: ${said.unknowns.map(([name, unit]) => `${name} [${unit}]`).join(", ")}.`;
    } catch (error) {
      words.textContent = error.message;
    }
  }, 150);
};

/** Begins to listen; `task` gives the server one. */
export const listen = (to, task) => {
  [address, give] = [to, task];
  find("undo").addEventListener("click", () => give({ task: "undo" }));
  find("redo").addEventListener("click", () => give({ task: "redo" }));
  find("search").addEventListener("click", () => give({ task: "search" }));
  find("add").addEventListener("submit", (event) => {
    event.preventDefault();
    give({ task: "add", effect: find("effect").value });
  });
  find("formula-line").addEventListener("input", checkFormula);
  find("own").addEventListener("submit", (event) => {
    event.preventDefault();
    give({ task: "formula", line: find("formula-line").value.trim() });
  });
  document.addEventListener("keydown", (event) => {
    const isTyped = event.target.matches("input:not([type=range]), select, textarea");
    if (isTyped || !(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") return;
    event.preventDefault();
    give({ task: event.shiftKey ? "redo" : "undo" });
  });
};
