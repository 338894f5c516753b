// A divider over a picture: left of it one surface is shown, right of it another. Dragged, or moved with the keys.

const STEP = 0.02;
const LEAP = 0.1;

/** Lets an element with role slider divide a canvas; `moved` is called after each move. */
export const divider = (canvas, element, moved) => {
  let share = 0.5;
  const set = (to) => {
    share = Math.min(1, Math.max(0, to));
    element.style.left = `${100 * share}%`;
    const percent = Math.round(100 * share);
    element.setAttribute("aria-valuenow", percent);
    element.setAttribute("aria-valuetext", `before on the left ${percent} %, after on the right ${100 - percent} %`);
    moved();
  };
  const KEYS = { ArrowLeft: -STEP, ArrowDown: -STEP, ArrowRight: STEP, ArrowUp: STEP, PageDown: -LEAP, PageUp: LEAP, Home: -1, End: 1 };
  element.addEventListener("keydown", (event) => {
    if (!(event.key in KEYS)) return;
    event.preventDefault();
    event.stopPropagation();
    set(share + KEYS[event.key]);
  });
  element.addEventListener("pointerdown", (start) => {
    const follow = (event) => {
      const box = canvas.getBoundingClientRect();
      set((event.clientX - box.left) / box.width);
    };
    const end = () => element.removeEventListener("pointermove", follow);
    element.setPointerCapture(start.pointerId);
    element.addEventListener("pointermove", follow);
    for (const event of ["pointerup", "pointercancel"]) element.addEventListener(event, end, { once: true });
  });
  return {
    isOn: () => !element.hidden,
    /** Column of the canvas on which the divider stands [px]. */
    x: () => share * canvas.width,
    show: (is) => {
      element.hidden = !is;
      set(share);
    },
  };
};
