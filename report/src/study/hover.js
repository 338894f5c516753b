"use strict";
// Says place and value of the map's pixel under the pointer, for all maps of the same scan.
(() => {
  const tip = document.getElementById("tip");
  const decoded = new Map();

  const valuesOf = (image) => {
    if (!decoded.has(image)) {
      const bytes = Uint8Array.from(atob(image.dataset.values), (c) => c.charCodeAt(0));
      decoded.set(image, new DataView(bytes.buffer));
    }
    return decoded.get(image);
  };

  const text = (value) => value.replace("-", "\u2212");

  const says = (image, at) => {
    const value = valuesOf(image).getInt16(2 * at, true);
    const words = image.dataset.words;
    if (words) return words.split("|")[value];
    return value === -32768 ? "missing" : text((value / image.dataset.perUm).toFixed(1)) + " \u00b5m";
  };

  const show = (image, event) => {
    const box = image.getBoundingClientRect();
    const { nx, ny, xMm, yMm, pitchMm } = image.dataset;
    const within = (part, count) => Math.min(count - 1, Math.max(0, Math.floor(part * count)));
    const i = within((event.clientX - box.left) / box.width, nx);
    const j = within((box.bottom - event.clientY) / box.height, ny);
    const x = text((+xMm + i * pitchMm).toFixed(2));
    const y = text((+yMm + j * pitchMm).toFixed(2));
    const maps = image.closest(".pair").querySelectorAll("image.map");
    const lines = Array.from(maps, (map) => map.dataset.label + ": " + says(map, j * nx + i));
    tip.textContent = ["x " + x + " mm, y " + y + " mm", ...lines].join("\n");
    tip.style.display = "block";
    tip.style.left = Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 4) + "px";
    tip.style.top = Math.min(event.clientY + 14, innerHeight - tip.offsetHeight - 4) + "px";
  };

  // Maps may come and go after this script has run.
  document.addEventListener("pointermove", (event) => {
    const image = event.target.closest ? event.target.closest("image.map") : null;
    if (image) show(image, event);
    else tip.style.display = "none";
  });
})();
