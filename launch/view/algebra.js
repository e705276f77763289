// Vectors, poses and matrices. A pose is [x, y, z, qx, qy, qz, qw] in m; a matrix has 16 numbers, column by column.

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scale = (a, factor) => [a[0] * factor, a[1] * factor, a[2] * factor];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(a[0], a[1], a[2]);
const normalized = (a) => scale(a, 1 / (length(a) || 1));
const clamp = (value, least, greatest) => Math.min(greatest, Math.max(least, value));

const IDENTITY = [0, 0, 0, 0, 0, 0, 1];

/** The vector turned by the pose's rotation. */
function turned(pose, v) {
  const q = [pose[3], pose[4], pose[5]];
  const t = scale(cross(q, v), 2);
  return add(add(v, scale(t, pose[6])), cross(q, t));
}

/** The point of the pose's frame, in the frame around it. */
const placed = (pose, point) => add(turned(pose, point), pose);

/** a · b: first b, then a. */
function compose(a, b) {
  const [x, y, z] = placed(a, b);
  const [ax, ay, az, aw] = [a[3], a[4], a[5], a[6]];
  const [bx, by, bz, bw] = [b[3], b[4], b[5], b[6]];
  return [
    x, y, z,
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

/** Rotation by an angle (rad) about a unit axis, as a pose. */
function rotationAbout(axis, angle) {
  const s = Math.sin(angle / 2);
  return [0, 0, 0, axis[0] * s, axis[1] * s, axis[2] * s, Math.cos(angle / 2)];
}

/** The matrix of a pose. */
function matrixOf(pose) {
  const [x, y, z] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => turned(pose, axis));
  return new Float32Array([...x, 0, ...y, 0, ...z, 0, pose[0], pose[1], pose[2], 1]);
}

/** a · b. */
function multiply(a, b) {
  const product = new Float32Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      let sum = 0;
      for (let i = 0; i < 4; i++) sum += a[i * 4 + row] * b[column * 4 + i];
      product[column * 4 + row] = sum;
    }
  }
  return product;
}

/** From the world to a viewer at `eye` who looks along -z, with x to the right and y up. */
function lookAt(eye, target, up) {
  const back = normalized(subtract(eye, target));
  const right = normalized(cross(up, back));
  const above = cross(back, right);
  return new Float32Array([
    right[0], above[0], back[0], 0,
    right[1], above[1], back[1], 0,
    right[2], above[2], back[2], 0,
    -dot(right, eye), -dot(above, eye), -dot(back, eye), 1,
  ]);
}

/** Perspective with a vertical field of view (rad). */
function perspective(fovY, aspect, near, far) {
  const f = 1 / Math.tan(fovY / 2);
  const depth = near - far;
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / depth, -1, 0, 0, (2 * far * near) / depth, 0]);
}

/** Parallel projection of a cube with half edge `half` about the viewer's axis, `far` deep. */
function parallel(half, far) {
  return new Float32Array([1 / half, 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, -2 / far, 0, 0, 0, -1, 1]);
}

/** A matrix applied to a point; [x, y, z, w]. */
function transformed(m, p) {
  return [0, 1, 2, 3].map((row) => m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row]);
}

/** `#rrggbb` as three numbers from 0 to 1. */
const colourOf = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
const mixed = (a, b, part) => a.map((value, i) => value * (1 - part) + b[i] * part);

/** Index of the last entry that is not greater than `t`; -1 if there is none. */
function lastAt(times, t) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
