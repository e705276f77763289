// An orbiting camera with z up, and the pointer, wheel and touch gestures that move it.

const FIELD_OF_VIEW = (36 * Math.PI) / 180;

class Camera {
  /** A camera that frames the `points`. */
  constructor(points) {
    this.points = points;
    const bound = (pick) => [0, 1, 2].map((axis) => pick(...points.map((point) => point[axis])));
    [this.low, this.high] = [bound(Math.min), bound(Math.max)];
    this.radius = Math.max(0.5, length(subtract(this.high, this.low)) / 2);
    this.viewport = [1, 1];
    this.azimuth = -1.25;
    this.elevation = 0.75;
    this.target = scale(add(this.low, this.high), 0.5);
    this.distance = 3 * this.radius;
  }

  /** Unit vector from the target to the eye. */
  get outward() {
    const flat = Math.cos(this.elevation);
    return [flat * Math.cos(this.azimuth), flat * Math.sin(this.azimuth), Math.sin(this.elevation)];
  }

  get eye() {
    return add(this.target, scale(this.outward, this.distance));
  }

  /** From straight above, y points up in the picture; everywhere else z does. */
  get up() {
    return this.elevation > 1.5533 ? [-Math.cos(this.azimuth), -Math.sin(this.azimuth), 0] : [0, 0, 1];
  }

  /** The world in clip coordinates. */
  viewProjection() {
    const [width, height] = this.viewport;
    const near = Math.max(0.01, this.distance / 200);
    const far = this.distance + 12 * this.radius;
    return multiply(perspective(FIELD_OF_VIEW, width / height, near, far), lookAt(this.eye, this.target, this.up));
  }

  /** A world point in pixels from the viewport's top left corner, and its depth (m); undefined behind the eye. */
  project(point, matrix = this.viewProjection()) {
    const [x, y, , w] = transformed(matrix, point);
    if (w <= 0) return undefined;
    const [width, height] = this.viewport;
    return [((x / w + 1) / 2) * width, ((1 - y / w) / 2) * height, w];
  }

  /** Moves so that all points of the scene are in the picture, with a margin; by default from the front and above. */
  frame(azimuth = -1.25, elevation = undefined) {
    const [width, height] = this.viewport;
    // A tall picture has room for more depth.
    [this.azimuth, this.elevation] = [azimuth, elevation ?? (width > 1.3 * height ? 0.78 : 1.0)];
    const slopeY = Math.tan(FIELD_OF_VIEW / 2) * 0.9;
    const slopeX = (slopeY * width) / height;
    const back = this.outward;
    const right = normalized(cross(this.up, back));
    const above = cross(back, right);
    this.target = scale(add(this.low, this.high), 0.5);
    for (let round = 0; round < 8; round++) {
      const seen = this.points.map((point) => subtract(point, this.target)).map((p) => [dot(p, right), dot(p, above), dot(p, back)]);
      this.distance = Math.max(0.3, ...seen.map(([x, y, z]) => Math.max(Math.abs(x) / slopeX, Math.abs(y) / slopeY) + z));
      const share = (i) => seen.map((p) => p[i] / (this.distance - p[2]));
      const middle = (i) => ((Math.max(...share(i)) + Math.min(...share(i))) / 2) * this.distance;
      this.target = add(this.target, add(scale(right, middle(0)), scale(above, middle(1))));
    }
  }

  orbit(dx, dy) {
    this.azimuth -= dx * 0.006;
    this.elevation = clamp(this.elevation + dy * 0.006, -0.2, Math.PI / 2);
  }

  /** Moves the target by pixels, parallel to the picture. */
  pan(dx, dy) {
    const perPixel = (2 * Math.tan(FIELD_OF_VIEW / 2) * this.distance) / this.viewport[1];
    const right = normalized(cross(this.up, this.outward));
    const above = cross(this.outward, right);
    this.target = add(this.target, add(scale(right, -dx * perPixel), scale(above, dy * perPixel)));
  }

  /** Comes nearer by a factor, towards the pixel (x, y). */
  zoom(factor, x = this.viewport[0] / 2, y = this.viewport[1] / 2) {
    const before = this.distance;
    this.distance = clamp(this.distance * factor, 0.15, 12 * this.radius);
    const [dx, dy] = [this.viewport[0] / 2 - x, this.viewport[1] / 2 - y];
    const moved = before / this.distance - 1;
    this.pan(dx * moved, dy * moved);
  }
}

/** Lets gestures on `element` move the camera; `changed` is called after each. */
function handleGestures(element, camera, changed) {
  const pointers = new Map();
  const place = (event) => {
    const box = element.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const spread = () => {
    const [a, b] = [...pointers.values()];
    return { middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], gap: Math.hypot(a[0] - b[0], a[1] - b[1]) || 1 };
  };
  element.addEventListener("pointerdown", (event) => {
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, place(event));
  });
  element.addEventListener("pointermove", (event) => {
    const last = pointers.get(event.pointerId);
    if (!last) return;
    const before = pointers.size === 2 ? spread() : undefined;
    const now = place(event);
    pointers.set(event.pointerId, now);
    const [dx, dy] = [now[0] - last[0], now[1] - last[1]];
    if (before) {
      const after = spread();
      camera.pan(after.middle[0] - before.middle[0], after.middle[1] - before.middle[1]);
      camera.zoom(before.gap / after.gap, ...after.middle);
    } else if (event.shiftKey || event.buttons & 6) {
      camera.pan(dx, dy);
    } else {
      camera.orbit(dx, dy);
    }
    changed();
  });
  for (const end of ["pointerup", "pointercancel"]) {
    element.addEventListener(end, (event) => pointers.delete(event.pointerId));
  }
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  const zoomed = (event) => {
    event.preventDefault();
    camera.zoom(Math.exp(clamp(event.deltaY * (event.deltaMode ? 20 : 1), -240, 240) * 0.0012), ...place(event));
    changed();
  };
  element.addEventListener("wheel", zoomed, { passive: false });
}
