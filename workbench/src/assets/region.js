// What is different in a region: its residual in each pass, and its conditions against those elsewhere.

import { make, number } from "./dom.js";

// Conditions that are shown.
const MOST = 8;

const percent = ({ value, error }) =>
  `${number(100 * value, 3)} %${error === null ? "" : ` \u00b1 ${number(100 * error, 2)} %`}`;

const table = (caption, heads, rows) => make("table", {}, make("caption", {}, caption),
  make("thead", {}, make("tr", {}, ...heads.map((head) => make("th", { scope: "col" }, head)))),
  make("tbody", {}, ...rows.map(([first, ...others]) => make("tr", {}, make("th", { scope: "row" }, first),
    ...others.map((value) => make("td", {}, value))))));

const passRow = (trials) => ({ trial, pass, tiles, residual }) => {
  const { force, feed, isFitted } = trials[trial].passes[pass];
  const name = `${trials[trial].name}, pass ${pass + 1}${isFitted ? "" : ", held out"}`;
  return [name, `${number(force, 3)} N`, `${number(feed, 3)} mm/s`, number(tiles), percent(residual)];
};

const conditionRow = ({ name, unit, here, elsewhere, distance, correlation }) => {
  const shown = (value) => `${number(value, 3)} ${unit}`;
  return [name, shown(here), shown(elsewhere), number(distance, 2), number(correlation, 2)];
};

/** The tables of a region. */
export const regionTables = (region, trials) => {
  const where = make("p", { "data-tiles": region.tiles }, `${region.words}: ${number(region.tiles)} tiles of this pass.`,
    region.elsewhere ? ` Elsewhere the residual is ${percent(region.elsewhere)}.` : "");
  const passes = table("Residual in the region: measured \u2212 simulated removal as a share of it, or share of substrate",
    ["pass", "force", "feed", "tiles", "residual"], region.passes.map(passRow(trials)));
  const conditions = table("Conditions of this pass, those that differ and go with the residual first",
    ["condition", "here", "elsewhere", "difference [σ]", "correlation with the residual"],
    region.covariates.slice(0, MOST).map(conditionRow));
  return [where, passes, conditions];
};
