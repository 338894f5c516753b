// Small helpers for the document; text only ever becomes text.

export const find = (id) => document.getElementById(id);

/** An element with properties and children; strings become text. */
export const make = (name, properties = {}, ...children) => {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key in element && key !== "list") element[key] = value;
    else element.setAttribute(key, value);
  }
  element.append(...children);
  return element;
};

/** A number with separators between thousands and a real minus. */
export const number = (value, digits = 4) => {
  if (value === null || value === undefined || !Number.isFinite(value)) return "missing";
  const power = value === 0 ? 0 : Math.floor(Math.log10(Math.abs(value)));
  if (power >= 7 || power < -4) return value.toExponential(digits - 1).replace("-", "\u2212").replace("e+", "e");
  const fraction = Math.max(0, digits - 1 - power);
  return value.toLocaleString("en", { maximumFractionDigits: Math.min(fraction, 12) }).replace("-", "\u2212");
};

/** The answer of a request; what the server says where it refuses. */
export const ask = async (address, options) => {
  const answer = await fetch(address, options);
  if (!answer.ok) throw new Error((await answer.text()) || answer.statusText);
  return answer;
};
