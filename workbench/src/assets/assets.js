// A data set of assets: a table that is filtered and sorted in the page, pictures, one item in full.

import { ask, find, make, number } from "./dom.js";
import { address, askRows, pager, showFaults } from "./set.js";

const PAGE = 50;
// Columns of words with few values are chosen from a list.
const MOST_CHOICES = 12;

let columns = [];
let rows = [];
let sorted = { at: 0, down: false };

const filters = find("filters");
const values = (at) => rows.map((row) => row[at]);

const wordFilter = ({ key, words }, at) => {
  const own = [...new Set(values(at))].sort();
  if (own.length > MOST_CHOICES || key === "id" || key === "source") {
    return make("label", {}, `${words} `, make("input", { type: "text", name: key, autocomplete: "off", placeholder: "part of it" }));
  }
  const options = own.map((value) => make("option", { value }, value));
  return make("label", {}, `${words} `, make("select", { name: key }, make("option", { value: "" }, "all"), ...options));
};

const rangeFilter = ({ key, words, unit }, at) => {
  const own = values(at).filter((value) => value !== null);
  const ends = own.length ? [own.reduce((a, b) => Math.min(a, b)), own.reduce((a, b) => Math.max(a, b))] : [null, null];
  const field = (end, k) => make("input", { "type": "number", "step": "any", "name": `${key} ${end}`, "className": "field",
    "aria-label": `${words}, ${end}`, "placeholder": ends[k] === null ? "" : number(ends[k], 3) });
  return make("div", { className: "range" }, make("span", {}, words, " ", make("span", { className: "fine" }, unit && `[${unit}]`)),
    field("at least", 0), " to ", field("at most", 1));
};

const showFilters = () => {
  const at = (kind) => columns.map((column, k) => [column, k]).filter(([column]) => column.kind === kind);
  find("word-filters").replaceChildren(...at("words").map(([column, k]) => wordFilter(column, k)));
  find("ranges").replaceChildren(...at("number").map(([column, k]) => rangeFilter(column, k)));
};

/** True for a row that all filters admit. */
const admits = () => {
  const set = Object.fromEntries([...new FormData(filters)].filter(([, value]) => value !== ""));
  const tests = [];
  for (const [at, { key, kind }] of columns.entries()) {
    if (kind === "words") {
      const text = set[key]?.toLowerCase();
      const whole = filters.elements[key].tagName === "SELECT";
      if (text) tests.push((row) => (whole ? row[at].toLowerCase() === text : row[at].toLowerCase().includes(text)));
    } else {
      const [low, high] = ["at least", "at most"].map((end) => set[`${key} ${end}`]);
      if (low !== undefined) tests.push((row) => row[at] !== null && row[at] >= +low);
      if (high !== undefined) tests.push((row) => row[at] !== null && row[at] <= +high);
    }
  }
  return (row) => tests.every((test) => test(row));
};

const showHead = () => {
  const head = ({ words, unit, kind }, at) => {
    const sort = sorted.at === at ? (sorted.down ? "descending" : "ascending") : "none";
    const button = make("button", { type: "button" }, words, unit && ` [${unit}]`, sort === "none" ? "" : sorted.down ? " \u25be" : " \u25b4");
    button.addEventListener("click", () => {
      sorted = { at, down: sorted.at === at && !sorted.down };
      update();
      find("items").querySelectorAll("thead button")[at].focus();
    });
    return make("th", { "scope": "col", "className": kind === "number" ? "n" : "", "aria-sort": sort }, button);
  };
  const picture = find("pictures").checked ? [make("th", { scope: "col" }, make("span", { className: "fine" }, "picture"))] : [];
  const [item, ...others] = columns.map(head);
  find("items").tHead.replaceChildren(make("tr", {}, item, ...picture, ...others));
};

const picture = (id, isThere) => (isThere
  ? make("img", { src: `${address}/items/${encodeURIComponent(id)}/preview.png`, alt: `picture of ${id}`, loading: "lazy", width: 320, height: 240 })
  : make("span", { className: "fine" }, "no picture"));

const showRows = (shown) => {
  const line = (row) => {
    const id = row[0];
    const open = make("button", { type: "button", className: "link" }, id);
    open.addEventListener("click", () => showItem(id, row.at(-1)));
    const cell = ({ kind }, at) => {
      if (at === 0) return make("th", { scope: "row" }, open);
      return kind === "number" ? make("td", { className: "n" }, number(row[at])) : make("td", { className: "name" }, row[at]);
    };
    const thumbnail = find("pictures").checked ? [make("td", { className: "thumbnail" }, picture(id, row.at(-1)))] : [];
    const [item, ...others] = columns.map(cell);
    return make("tr", {}, item, ...thumbnail, ...others);
  };
  find("items").tBodies[0].replaceChildren(...shown.map(line));
};

/** Lists the figures of a value, one a line. */
const figures = (value) => Object.entries(value).map(([key, own]) => make("tr", {}, make("th", { scope: "row" }, key.replaceAll("_", " ")),
  make("td", {}, typeof own === "number" ? number(own, 5) : typeof own === "object" ? JSON.stringify(own) : String(own))));

const showItem = async (id, isThere) => {
  const box = find("item");
  try {
    const item = await (await ask(`${address}/items/${encodeURIComponent(id)}`)).json();
    const { measured, files, ...own } = item;
    const { welds, ...part } = measured;
    const close = make("button", { type: "button" }, "Close");
    close.addEventListener("click", () => { box.hidden = true; });
    const table = (words, lines) => make("div", { className: "scroll" }, make("table", {}, make("caption", {}, words), make("tbody", {}, ...lines)));
    const sizes = Object.entries(files).map(([name, { bytes }]) => make("tr", {}, make("th", { scope: "row" }, name), make("td", { className: "n" }, `${number(bytes / 1e6, 3)} MB`)));
    box.replaceChildren(make("h2", { tabIndex: -1 }, id), close, make("div", { className: "large" }, picture(id, isThere)),
      ...welds.map((weld, k) => table(`weld ${k + 1}`, figures(weld))), table("part", figures(part)), table("item", figures(own)), table("files", sizes));
    box.hidden = false;
    box.querySelector("h2").focus();
  } catch (error) {
    showFaults([error.message]);
  }
};

const show = pager(PAGE, showRows);

const update = () => {
  const { at, down } = sorted;
  const order = (a, b) => {
    if (a[at] === b[at]) return 0;
    if (a[at] === null || b[at] === null) return a[at] === null ? 1 : -1;
    const less = typeof a[at] === "number" ? a[at] - b[at] : a[at].localeCompare(b[at]);
    return down ? -less : less;
  };
  const shown = rows.filter(admits()).sort(order);
  const items = (count) => (count === 1 ? "1 item" : `${number(count, 9)} items`);
  find("shown").textContent = shown.length === rows.length ? items(rows.length) : `${number(shown.length, 9)} of ${items(rows.length)}`;
  find("shown").dataset.count = shown.length;
  showHead();
  show(shown);
};

const begin = async () => {
  const set = await askRows();
  if (!set) return;
  ({ columns, rows } = set);
  showFilters();
  update();
};

filters.addEventListener("input", update);
filters.addEventListener("submit", (event) => event.preventDefault());
// The fields are empty only after the event.
filters.addEventListener("reset", () => setTimeout(update));
begin();
