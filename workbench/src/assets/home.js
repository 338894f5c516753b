// A trial from files: they are sent, a trial.toml is drafted, corrected by hand and kept.

import { ask, find, make } from "./dom.js";

const form = find("files");
const zone = find("drop");
const said = find("drop-said");
let dropped = [];

const query = (more = {}) => new URLSearchParams({ campaign: find("campaign").value.trim(), trial: find("trial").value.trim(), ...more });

const say = (words, isFault = false) => {
  said.textContent = words;
  said.classList.toggle("bad", isFault);
};

const list = (heading, lines) => (lines.length ? [make("h3", {}, heading), make("ul", {}, ...lines.map((line) => make("li", {}, line)))] : []);

const choose = (files) => {
  dropped = [...files];
  say(dropped.length ? `${dropped.length} files: ${dropped.map((file) => file.name).join(", ")}` : "");
};

/** Shows the draft. */
const showDraft = ({ text, seen, open }) => {
  find("draft-seen").replaceChildren(...list("Seen in the files", seen), ...list("To fill in", open));
  find("draft-text").value = text;
  find("draft").hidden = false;
  find("draft-text").focus();
  find("draft-text").setSelectionRange(0, 0);
  find("draft-text").scrollTop = 0;
};

const send = async (event) => {
  event.preventDefault();
  const files = dropped.length ? dropped : [...find("chosen").files];
  if (!files.length) return say("no files yet: drop or choose the scans and logs of one trial", true);
  try {
    await ask(`/drop/begin?${query()}`, { method: "POST" });
    for (const [k, file] of files.entries()) {
      say(`sending ${file.name} (${k + 1} of ${files.length})`);
      await ask(`/drop/file?${query({ file: file.name })}`, { method: "PUT", body: file });
    }
    say("looking at the files");
    showDraft(await (await ask(`/drop/draft?${query()}`, { method: "POST" })).json());
    say("Correct what is below, then keep it.");
  } catch (error) {
    say(error.message, true);
  }
  return undefined;
};

const keep = async (event) => {
  event.preventDefault();
  const body = JSON.stringify({ text: find("draft-text").value });
  const headers = { "Content-Type": "application/json" };
  try {
    const { findings, address } = await (await ask(`/drop/save?${query()}`, { method: "POST", body, headers })).json();
    find("draft").hidden = true;
    say("");
    said.append("The trial is kept. ", make("a", { href: address, id: "open-trial" }, "Open it"), ...list("Its checks say", findings));
  } catch (error) {
    say(error.message, true);
  }
};

form.addEventListener("submit", send);
find("draft").addEventListener("submit", keep);
find("chosen").addEventListener("change", (event) => choose(event.target.files));
zone.addEventListener("dragover", (event) => event.preventDefault());
zone.addEventListener("drop", (event) => {
  event.preventDefault();
  choose(event.dataTransfer.files);
});
