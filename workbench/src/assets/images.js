// A data set of labelled images: pages of pictures with their labels over them.

import { find, make, number } from "./dom.js";
import { address, askRows, pager } from "./set.js";

const PAGE = 24;
const CHOICES = ["split", "workpiece", "treatment", "looks"];
const filters = find("filters");
let rows = [];
let legends = {};

const source = (id, layer) => `${address}/images/${encodeURIComponent(id)}/${layer}`;
const percent = (share) => (share === null ? "unknown" : `${number(100 * share, 3)} %`);

/** Words in place of a picture that the set does not hold. */
const lost = (event) => event.target.replaceWith(make("span", { className: "bad" }, "this picture is missing or broken"));

const picture = (id, layer, alt, className) => {
  const image = make("img", { src: source(id, layer), alt, loading: "lazy", className });
  image.addEventListener("error", lost);
  return image;
};

/** Shares of the classes of a label. */
const classes = ([, sanded, unsanded, ignored]) => {
  const all = Math.max(1, sanded + unsanded + ignored);
  return [sanded, unsanded, ignored].map((pixels) => number((100 * pixels) / all, 3)).join(" / ");
};

const card = (row) => {
  const layer = find("layer").value;
  const photo = picture(row.id, "photograph", `${row.workpiece}, ${row.treatment}`, "");
  const over = layer ? [picture(row.id, layer, "", "over")] : [];
  const line = (words, value) => [make("dt", {}, words), make("dd", {}, value)];
  const facts = make("dl", {}, ...line("workpiece", row.workpiece), ...line("coating", row.treatment), ...line("split", row.split),
    ...line("exposed", percent(row.exposed)), ...line("labels agree", percent(row.agreement)),
    ...line("by appearance", `${classes(row.appearance)} %`), ...line("by dose", `${classes(row.dose)} %`),
    ...line("looks", row.looks.join(", ") || "none"));
  return make("figure", { className: "image" }, make("div", { className: "stack" }, photo, ...over),
    make("figcaption", {}, make("strong", {}, row.id), facts));
};

const show = pager(PAGE, (shown) => {
  find("images").replaceChildren(...shown.map(card));
  find("images").dataset.layer = find("layer").value;
});

/** A colour of the labels with its words. */
const key = ([colour, words]) => {
  const swatch = make("i");
  swatch.style.background = colour;
  return make("span", { className: "key" }, swatch, words && ` ${words} `);
};

const blend = () => {
  const { value } = find("blend");
  find("images").style.setProperty("--blend", value / 100);
  find("blend").setAttribute("aria-valuetext", `${value} %`);
};

const update = () => {
  const set = Object.fromEntries(new FormData(filters));
  const has = (row, key) => !set[key] || (key === "looks" ? row.looks.includes(set[key]) : row[key] === set[key]);
  const text = set.id.toLowerCase();
  const shown = rows.filter((row) => CHOICES.every((key) => has(row, key)) && row.id.toLowerCase().includes(text));
  const images = (count) => (count === 1 ? "1 image" : `${number(count, 9)} images`);
  find("shown").textContent = (shown.length === rows.length ? images(rows.length) : `${number(shown.length, 9)} of ${images(rows.length)}`)
    + ". Shares of classes: sanded / unsanded / ignored, of the workpiece.";
  find("shown").dataset.count = shown.length;
  find("classes").replaceChildren(...(legends[find("layer").value] ?? []).map(key));
  show(shown);
};

const begin = async () => {
  const set = await askRows();
  if (!set) return;
  ({ rows, legends } = set);
  for (const key of CHOICES) {
    const own = [...new Set(rows.flatMap((row) => row[key]))].sort();
    filters.elements[key].replaceChildren(make("option", { value: "" }, "all"), ...own.map((value) => make("option", { value }, value)));
  }
  blend();
  update();
};

filters.addEventListener("submit", (event) => event.preventDefault());
filters.addEventListener("input", (event) => (event.target === find("blend") ? blend() : update()));
begin();
