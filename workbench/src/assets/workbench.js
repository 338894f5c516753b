// The page of a campaign: asks the server for its state again and again, and gives it tasks.

import { ask, find } from "./dom.js";
import * as panels from "./panels.js";
import * as part from "./part.js";

const { address } = find("bench").dataset;
const RETRY = 2000;
let since = 0;

const fault = (words) => {
  const box = find("fault");
  if (box.textContent !== (words || "")) box.textContent = words || "";
  box.hidden = !words;
};

const working = (state) => {
  const { job } = state;
  const more = state.waiting ? `, ${state.waiting} more waiting` : "";
  const reading = state.phase === "reading" ? "reading the measurements" : "";
  find("work").textContent = job ? `${job.what}${more}` : reading;
  find("progress").hidden = !job && !reading;
  find("cancel").hidden = !job;
  // Without a value the bar only says that something goes on.
  if (job && job.done) find("progress").value = job.done / Math.max(1, job.all);
  else find("progress").removeAttribute("value");
};

const give = async (task) => {
  try {
    const headers = { "content-type": "application/json" };
    await ask(`${address}/task`, { method: "POST", headers, body: JSON.stringify(task) });
  } catch (error) {
    fault(error.message);
  }
};

const show = async (state) => {
  since = state.version;
  find("about").textContent = state.about;
  find("about").title = state.notes.join("\n");
  working(state);
  fault(state.fault);
  await panels.show(state);
  part.show(state);
  document.body.dataset.version = state.version;
  document.body.dataset.idle = state.phase === "open" && !state.job && !state.waiting;
};

const follow = async () => {
  for (;;) {
    try {
      const state = await (await ask(`${address}/state?since=${since}`)).json();
      await show(state);
      if (state.phase === "closed") {
        fault(`${state.fault}\nMend it, then load this page again.`);
        return;
      }
    } catch (error) {
      const lost = error instanceof TypeError;
      fault(lost ? "The server does not answer: it was ended, or the tunnel is closed. What was done is kept; this page goes on when it is back at this address."
        : error.message);
      await new Promise((done) => { setTimeout(done, RETRY); });
    }
  }
};

find("cancel").addEventListener("click", () => give({ task: "cancel" }));
panels.listen(address, give);
part.listen(address);
follow();
