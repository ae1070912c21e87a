// Pointers and keys, as changes of an orbit.

/** Degrees that one pixel turns, and that an arrow key turns. */
const TURN_DEG = 0.4, KEY_DEG = 5;
/** Pixels that an arrow key moves. */
const KEY_PX = 20;
/** How much nearer a key brings. */
const KEY_ZOOM = 1.2;
/** A wheel's largest step in pixels: some send thousands at once. */
const WHEEL_PX = 500;

/** Moves what is looked at, so that it stays under the pointer. */
function pan(orbit, right_px, down_px, height_px) {
  const [yaw, pitch] = [orbit.yaw, orbit.pitch].map((angle_deg) => angle_deg * Math.PI / 180);
  // As wide as a pixel is at the target with a field of view of 45 degrees.
  const pixel_m = 2 * Math.tan(Math.PI / 8) * orbit.radius / Math.max(height_px, 1);
  const right = [Math.cos(yaw), 0, -Math.sin(yaw)];
  const up = [-Math.sin(yaw) * Math.sin(pitch), Math.cos(pitch), -Math.cos(yaw) * Math.sin(pitch)];
  orbit.target = orbit.target.map((at, axis) => at + pixel_m * (down_px * up[axis] - right_px * right[axis]));
}

/** One pointer turns, with the right button or Shift it moves; two pointers move and zoom. */
function followPointers(canvas, turn) {
  const pointers = new Map();
  const middle = () => {
    const all = [...pointers.values()];
    const [x, y] = [0, 1].map((axis) => all.reduce((sum, at) => sum + at[axis], 0) / all.length);
    return { x, y, apart: all.length > 1 ? Math.hypot(all[0][0] - all[1][0], all[0][1] - all[1][1]) : 0 };
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!pointers.has(event.pointerId)) return;
    const before = middle();
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const after = middle();
    const [right_px, down_px] = [after.x - before.x, after.y - before.y];
    if (!right_px && !down_px && before.apart === after.apart) return;
    turn((orbit) => {
      if (pointers.size < 2 && !event.shiftKey && !(event.buttons & 6)) {
        orbit.yaw -= right_px * TURN_DEG;
        orbit.pitch += down_px * TURN_DEG;
        return;
      }
      if (before.apart > 0 && after.apart > 0) orbit.radius *= before.apart / after.apart;
      pan(orbit, right_px, down_px, canvas.clientHeight);
    });
  });
  const forget = (event) => pointers.delete(event.pointerId);
  canvas.addEventListener("pointerup", forget);
  canvas.addEventListener("pointercancel", forget);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
}

function followWheel(canvas, turn) {
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    // Lines and pages are the units of some browsers.
    const unit_px = [1, 16, canvas.clientHeight][event.deltaMode] ?? 1;
    const step_px = Math.max(-WHEEL_PX, Math.min(WHEEL_PX, event.deltaY * unit_px));
    turn((orbit) => { orbit.radius *= Math.exp(step_px * 0.001); });
  }, { passive: false });
}

function followKeys(canvas, turn, reset) {
  canvas.addEventListener("keydown", (event) => {
    const arrow = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    const zoom = { "+": 1 / KEY_ZOOM, "=": 1 / KEY_ZOOM, "-": KEY_ZOOM, "_": KEY_ZOOM }[event.key];
    if (!arrow && !zoom && event.key !== "Home" || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    if (event.key === "Home") return reset();
    turn((orbit) => {
      if (zoom) orbit.radius *= zoom;
      else if (event.shiftKey) pan(orbit, -KEY_PX * arrow[0], -KEY_PX * arrow[1], canvas.clientHeight);
      else [orbit.yaw, orbit.pitch] = [orbit.yaw + KEY_DEG * arrow[0], orbit.pitch - KEY_DEG * arrow[1]];
    });
  });
}

/** Calls `turn` with a function that changes an orbit, and `reset` where the model is to be shown as at first. */
export function follow(canvas, turn, reset) {
  followPointers(canvas, turn);
  followWheel(canvas, turn);
  followKeys(canvas, turn, reset);
  canvas.addEventListener("dblclick", reset);
}
