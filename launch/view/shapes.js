// Surfaces of shapes: triangles {positions, normals, indices} and, in `edges`, pairs of points along sharp edges.

const ROUND = 40;
const BANDS = 10;

/** The surface and edges of a body's shape, in the shape's own frame. */
function surfaceOf(body) {
  if (body.box) return boxSurface(body.box.map((edge) => edge / 2));
  if (body.sphere) return turnedSurface(roundProfile(body.sphere, 0), []);
  if (body.capsule) return turnedSurface(roundProfile(body.capsule[0], body.capsule[1] / 2), []);
  if (body.cylinder) return cylinderSurface(body.cylinder[0], body.cylinder[1] / 2);
  return hullSurface(body.hull.corners, body.hull.faces);
}

/** Corners of the shape's bounds, in its own frame. */
function cornersOf(body) {
  const boxed = (x, y, z) => [-1, 1].flatMap((i) => [-1, 1].flatMap((j) => [-1, 1].map((k) => [i * x, j * y, k * z])));
  if (body.box) return boxed(...body.box.map((edge) => edge / 2));
  if (body.sphere) return boxed(body.sphere, body.sphere, body.sphere);
  if (body.capsule) return boxed(body.capsule[0], body.capsule[0], body.capsule[1] / 2 + body.capsule[0]);
  if (body.cylinder) return boxed(body.cylinder[0], body.cylinder[0], body.cylinder[1] / 2);
  return body.hull.corners;
}

/** Whether the way from `eye` to `point` crosses the bounds of an item ({frame, corners}) before it ends. */
function crossesBounds(eye, point, { frame, corners }) {
  const [from, to] = [eye, point].map((p) => turned([0, 0, 0, -frame[3], -frame[4], -frame[5], frame[6]], subtract(p, frame)));
  let [enters, leaves] = [0, 0.995];
  for (let axis = 0; axis < 3; axis++) {
    const along = corners.map((corner) => corner[axis]);
    const step = to[axis] - from[axis] || 1e-12;
    const ends = [Math.min(...along), Math.max(...along)].map((bound) => (bound - from[axis]) / step);
    enters = Math.max(enters, Math.min(...ends));
    leaves = Math.min(leaves, Math.max(...ends));
  }
  return enters < leaves;
}

function boxSurface(half) {
  const surface = { positions: [], normals: [], indices: [], edges: [] };
  for (let axis = 0; axis < 3; axis++) {
    const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    for (const side of [-1, 1]) {
      const first = surface.positions.length / 3;
      for (const [a, b] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        const [corner, normal] = [[0, 0, 0], [0, 0, 0]];
        corner[axis] = side * half[axis];
        corner[u] = a * side * half[u];
        corner[v] = b * half[v];
        normal[axis] = side;
        surface.positions.push(...corner);
        surface.normals.push(...normal);
      }
      surface.indices.push(first, first + 1, first + 2, first, first + 2, first + 3);
    }
    for (const a of [-1, 1]) {
      for (const b of [-1, 1]) {
        for (const side of [-1, 1]) {
          const corner = [0, 0, 0];
          corner[axis] = side * half[axis];
          corner[u] = a * half[u];
          corner[v] = b * half[v];
          surface.edges.push(...corner);
        }
      }
    }
  }
  return surface;
}

/** Profile of a sphere drawn apart by `half`, lowest point first: [distance from z, height, normal outwards, normal up]. */
function roundProfile(radius, half) {
  const at = (angle, shift) => [radius * Math.cos(angle), shift + radius * Math.sin(angle), Math.cos(angle), Math.sin(angle)];
  const profile = [];
  for (let band = 0; band <= BANDS; band++) profile.push(at(((band / BANDS - 1) * Math.PI) / 2, -half));
  for (let band = 0; band <= BANDS; band++) profile.push(at(((band / BANDS) * Math.PI) / 2, half));
  return profile;
}

/** What a profile describes when turned about z; circles at the `rims` (rows) are edges. */
function turnedSurface(profile, rims) {
  const surface = { positions: [], normals: [], indices: [], edges: [] };
  const point = ([distance, height], step) => {
    const angle = (step / ROUND) * 2 * Math.PI;
    return [distance * Math.cos(angle), distance * Math.sin(angle), height];
  };
  profile.forEach((row, i) => {
    for (let step = 0; step <= ROUND; step++) {
      surface.positions.push(...point(row, step));
      surface.normals.push(...point([row[2], row[3]], step));
      if (i + 1 < profile.length && step < ROUND) {
        const a = i * (ROUND + 1) + step;
        const b = a + ROUND + 1;
        surface.indices.push(a, a + 1, b + 1, a, b + 1, b);
      }
    }
  });
  for (const rim of rims) {
    for (let step = 0; step < ROUND; step++) {
      surface.edges.push(...point(profile[rim], step), ...point(profile[rim], step + 1));
    }
  }
  return surface;
}

function cylinderSurface(radius, half) {
  const profile = [
    [0, -half, 0, -1], [radius, -half, 0, -1], [radius, -half, 1, 0],
    [radius, half, 1, 0], [radius, half, 0, 1], [0, half, 0, 1],
  ];
  return turnedSurface(profile, [1, 3]);
}

function hullSurface(corners, faces) {
  const surface = { positions: [], normals: [], indices: [], edges: [] };
  const normalAcross = new Map();
  for (const face of faces) {
    const [a, b, c] = face.map((i) => corners[i]);
    const normal = normalized(cross(subtract(b, a), subtract(c, a)));
    for (const corner of [a, b, c]) {
      surface.indices.push(surface.indices.length);
      surface.positions.push(...corner);
      surface.normals.push(...normal);
    }
    for (let i = 0; i < 3; i++) {
      const [from, to] = [face[i], face[(i + 1) % 3]];
      const other = normalAcross.get(`${to} ${from}`);
      if (other && dot(other, normal) < 0.94) surface.edges.push(...corners[from], ...corners[to]);
      normalAcross.set(`${from} ${to}`, normal);
    }
  }
  return surface;
}

/** A flat rectangle with its border as edges. */
function sheetSurface([x, y]) {
  const corners = [[-x, -y], [x, -y], [x, y], [-x, y]].map(([a, b]) => [a / 2, b / 2, 0]);
  return {
    positions: corners.flat(),
    normals: corners.flatMap(() => [0, 0, 1]),
    indices: [0, 1, 2, 0, 2, 3],
    edges: corners.flatMap((corner, i) => [...corner, ...corners[(i + 1) % 4]]),
  };
}
