// What the pages of data sets share: faults, failures, pages of rows.

import { ask, find, make, number } from "./dom.js";

export const { address } = find("set").dataset;

/** Shows what cannot be read of a set. */
export const showFaults = (faults) => {
  const box = find("fault");
  box.hidden = !faults.length;
  box.replaceChildren(...faults.map((words) => make("p", {}, words)));
};

/** Lists what could not be made, with the reason and the command line that shows it again. */
export const showFailures = (failures) => {
  const box = find("failures");
  box.hidden = !failures.length;
  if (!failures.length) return;
  find("failures-heading").textContent = failures.length === 1 ? "One failure" : `${number(failures.length)} failures`;
  const [head, body] = box.querySelectorAll("thead, tbody");
  head.replaceChildren(make("tr", {}, ...["item", "stage", "reason", "command line"].map((words) => make("th", { scope: "col" }, words))));
  const row = ({ id, source, stage, reason, command }) => make("tr", {}, make("th", { scope: "row", title: source ?? "" }, id ?? ""),
    make("td", {}, stage ?? ""), make("td", { className: "reason" }, reason ?? ""), make("td", { className: "reason" }, make("code", {}, command ?? "")));
  body.replaceChildren(...failures.map(row));
};

/** The rows of the set; what the server says where it refuses. */
export const askRows = async () => {
  try {
    const begun = performance.now();
    const set = await (await ask(`${address}/rows`)).json();
    find("set").dataset.milliseconds = Math.round(performance.now() - begun);
    showFaults(set.faults);
    showFailures(set.failures);
    return set;
  } catch (error) {
    showFaults([error.message]);
    return null;
  }
};

/** Pages through rows: `show` gets those of the page. */
export const pager = (size, show) => {
  let rows = [];
  let page = 0;
  const paint = () => {
    const pages = Math.max(1, Math.ceil(rows.length / size));
    page = Math.min(Math.max(page, 0), pages - 1);
    find("previous").disabled = page === 0;
    find("following").disabled = page === pages - 1;
    find("page").textContent = `page ${page + 1} of ${number(pages)}`;
    show(rows.slice(page * size, (page + 1) * size));
  };
  const turn = (by) => () => { page += by; paint(); };
  find("previous").addEventListener("click", turn(-1));
  find("following").addEventListener("click", turn(1));
  return (all) => {
    rows = all;
    page = 0;
    paint();
  };
};
