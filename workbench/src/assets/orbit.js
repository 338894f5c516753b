// A camera around a part: what the pointer, the wheel and the keys do to it.

/** The camera after a drag by dx, dy pixels of a picture of some height; aside moves the part in the picture. */
export const dragged = (turn, [dx, dy], height, aside) => (aside
  ? { ...turn, right: turn.right + dx / height, up: turn.up - dy / height }
  : { ...turn, azimuth: turn.azimuth - dx * 0.35, elevation: Math.max(-89, Math.min(89, turn.elevation + dy * 0.35)) });

/** The camera after the wheel was turned. */
export const wheeled = (turn, delta) => ({ ...turn, zoom: Math.max(0.3, Math.min(40, turn.zoom * Math.exp(-delta * 0.0015))) });

/** The camera after a key; null for a key that does nothing. */
export const keyed = (turn, key, home) => {
  const tilted = (by) => ({ ...turn, elevation: Math.max(-89, Math.min(89, turn.elevation + by)) });
  switch (key) {
    case "ArrowLeft": return { ...turn, azimuth: turn.azimuth + 6 };
    case "ArrowRight": return { ...turn, azimuth: turn.azimuth - 6 };
    case "ArrowUp": return tilted(-6);
    case "ArrowDown": return tilted(6);
    case "+": return { ...turn, zoom: turn.zoom * 1.2 };
    case "-": return { ...turn, zoom: turn.zoom / 1.2 };
    case "0": return { ...home };
    default: return null;
  }
};

/** Lets pointer, wheel and keys turn a part; `look` is called with each new camera. */
export const orbit = (canvas, home, look) => {
  let turn = { ...home };
  const move = (to) => {
    turn = to;
    look(turn);
  };
  canvas.addEventListener("pointerdown", (start) => {
    const begun = turn;
    const scale = canvas.height / canvas.getBoundingClientRect().height;
    const follow = (event) => {
      const by = [event.clientX - start.clientX, event.clientY - start.clientY].map((pixels) => pixels * scale);
      move(dragged(begun, by, canvas.height, start.shiftKey || start.button === 2));
    };
    const end = () => canvas.removeEventListener("pointermove", follow);
    canvas.setPointerCapture(start.pointerId);
    canvas.addEventListener("pointermove", follow);
    for (const event of ["pointerup", "pointercancel"]) canvas.addEventListener(event, end, { once: true });
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    move(wheeled(turn, event.deltaY));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const to = event.ctrlKey || event.metaKey ? null : keyed(turn, event.key, home);
    if (!to) return;
    event.preventDefault();
    move(to);
  });
  return { turn: () => turn, reset: () => move({ ...home }) };
};
