// The way of the tool over the picture, a bar for the time of the pass, and the force over it.

import { ask, find, number } from "./dom.js";

const chart = find("force");
let motion = null;

/** The way of the drawn pass; asked for with the query of the picture. */
export const askMotion = async (address, query) => {
  motion = find("way").getAttribute("aria-pressed") === "true" && query.get("pass") !== "0"
    ? await (await ask(`${address}/motion?${query}`)).json() : null;
  find("moment").max = motion ? motion.seconds.length - 1 : 0;
};

const moment = () => Math.min(+find("moment").value, motion.seconds.length - 1);

const way = (context, from, to, colour) => {
  context.strokeStyle = colour;
  context.beginPath();
  for (const pixel of motion.pixels.slice(from, to + 1)) if (pixel) context.lineTo(...pixel);
  context.stroke();
};

/** Draws the way: done until the moment of the bar, then to come; a ring is the tool. */
export const paintMotion = (context) => {
  find("time").hidden = !motion;
  if (!motion) return;
  const k = moment();
  context.lineWidth = 2;
  way(context, k, motion.pixels.length - 1, "#8a93a3");
  way(context, 0, k, "#1c2330");
  const at = motion.pixels[k];
  if (at) {
    for (const [colour, width] of [["#fff", 5], ["#d55e00", 3]]) {
      context.strokeStyle = colour;
      context.lineWidth = width;
      context.beginPath();
      context.arc(...at, 7, 0, 2 * Math.PI);
      context.stroke();
    }
  }
  paintForce(k);
};

const paintForce = (k) => {
  const context = chart.getContext("2d");
  const { width, height } = chart;
  const most = 1.1 * Math.max(motion.setpoint, ...motion.forces, 1e-9);
  const x = (at) => (at / Math.max(1, motion.seconds.length - 1)) * width;
  const y = (force) => height - 2 - (Math.max(0, force) / most) * (height - 4);
  const line = (points, colour) => {
    context.strokeStyle = colour;
    context.beginPath();
    for (const point of points) context.lineTo(...point);
    context.stroke();
  };
  context.clearRect(0, 0, width, height);
  line([[0, y(motion.setpoint)], [width, y(motion.setpoint)]], "#8a93a3");
  line(motion.forces.map((force, at) => [x(at), y(force)]), "#0072b2");
  line([[x(k), 0], [x(k), height]], "#d55e00");
  const [px, py] = motion.placesMm[k];
  const words = find("moment-words");
  words.textContent = `${number(motion.seconds[k], 3)} s: ${number(motion.forces[k], 3)} N (setpoint ${number(motion.setpoint, 3)} N) at x ${number(px, 4)} mm, y ${number(py, 4)} mm`;
  words.dataset.force = motion.forces[k];
  chart.setAttribute("aria-label", `Logged force over the pass, 0 to ${number(most, 3)} N; the grey line is the setpoint`);
};
