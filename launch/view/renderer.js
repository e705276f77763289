// Draws surfaces with WebGL2: one light with shadows, sky light from above, sharp edges, a floor with a grid.

const SHADOW_SIZE = 2048;
const TO_LIGHT = normalized([-0.45, -0.55, 1]);

const SURFACE_VERTICES = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 viewProjection, model, shadowProjection;
out vec3 vWorld, vNormal, vShadow;
void main() {
  vec4 world = model * vec4(position, 1.0);
  vWorld = world.xyz;
  vNormal = mat3(model) * normal;
  vShadow = (shadowProjection * world).xyz * 0.5 + 0.5;
  gl_Position = viewProjection * world;
}`;

const SHADOW_LOOKUP = `
uniform highp sampler2DShadow shadowMap;
float lit(vec3 at, float bias) {
  if (any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)))) return 1.0;
  float sum = 0.0;
  for (int i = -1; i <= 1; i++)
    for (int j = -1; j <= 1; j++)
      sum += texture(shadowMap, vec3(at.xy + vec2(i, j) * 0.9 / ${SHADOW_SIZE}.0, at.z - bias));
  return sum / 9.0;
}`;

const SURFACE_FRAGMENTS = `#version 300 es
precision highp float;
in vec3 vWorld, vNormal, vShadow;
uniform vec3 colour, eye, toLight, skyLight, groundLight;
uniform float alpha;
${SHADOW_LOOKUP}
out vec4 pixel;
void main() {
  vec3 n = normalize(vNormal);
  vec3 toEye = normalize(eye - vWorld);
  if (dot(n, toEye) < 0.0) n = -n;
  float facing = max(dot(n, toLight), 0.0);
  float light = facing * lit(vShadow, 0.0012 + 0.004 * (1.0 - facing));
  float gloss = pow(max(dot(n, normalize(toLight + toEye)), 0.0), 48.0) * light;
  vec3 ambient = mix(groundLight, skyLight, n.z * 0.5 + 0.5);
  float fill = max(dot(n, normalize(vec3(0.8, 0.3, 0.25))), 0.0) * 0.16;
  vec3 linear = pow(colour, vec3(2.2)) * (ambient + fill + 0.85 * light) + vec3(0.10) * gloss;
  pixel = vec4(pow(min(linear, vec3(1.0)), vec3(1.0 / 2.2)), alpha);
}`;

const FLOOR_FRAGMENTS = `#version 300 es
precision highp float;
in vec3 vWorld, vNormal, vShadow;
uniform vec3 colour, lineColour, background, middle;
uniform float reach;
${SHADOW_LOOKUP}
out vec4 pixel;
float grid(float step) {
  vec2 at = vWorld.xy / step;
  vec2 width = fwidth(at);
  vec2 near = abs(fract(at - 0.5) - 0.5) / width;
  return (1.0 - min(min(near.x, near.y), 1.0)) * (1.0 - smoothstep(0.15, 0.5, max(width.x, width.y)));
}
void main() {
  float shade = mix(0.72, 1.0, lit(vShadow, 0.0008));
  vec3 ground = mix(colour * shade, lineColour, 0.55 * grid(1.0) + 0.22 * grid(0.25));
  float far = smoothstep(0.55, 1.0, distance(vWorld.xy, middle.xy) / reach);
  pixel = vec4(mix(ground, background, far), 1.0);
}`;

const FLAT_VERTICES = `#version 300 es
layout(location = 0) in vec3 position;
uniform mat4 viewProjection, model;
uniform float nearer;
void main() {
  gl_Position = viewProjection * (model * vec4(position, 1.0));
  gl_Position.z -= nearer * gl_Position.w;
}`;

const FLAT_FRAGMENTS = `#version 300 es
precision highp float;
uniform vec4 paint;
out vec4 pixel;
void main() { pixel = paint; }`;

/** What is drawn: {surface, matrix, colour, alpha, edges: [r, g, b, a] or undefined, shadow, sheet, id}. */
class Renderer {
  constructor(canvas, camera, floor) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: false, preserveDrawingBuffer: false });
    if (!gl) throw new Error("This browser has no WebGL2.");
    [this.gl, this.canvas, this.camera, this.floor] = [gl, canvas, camera, floor];
    this.surfaceProgram = this.program(SURFACE_VERTICES, SURFACE_FRAGMENTS);
    this.floorProgram = this.program(SURFACE_VERTICES, FLOOR_FRAGMENTS);
    this.flatProgram = this.program(FLAT_VERTICES, FLAT_FRAGMENTS);
    this.lines = { buffer: gl.createBuffer(), array: gl.createVertexArray() };
    gl.bindVertexArray(this.lines.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.lines.buffer);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    const reach = camera.radius * 2.6;
    this.ground = this.upload(sheetSurface([2 * reach, 2 * reach]));
    this.groundReach = reach;
    this.shadow = this.shadowTarget();
    this.pick = this.pickTarget();
    this.theme = undefined;
  }

  program(vertices, fragments) {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertices], [gl.FRAGMENT_SHADER, fragments]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const uniforms = {};
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
      const { name, type } = gl.getActiveUniform(program, i);
      uniforms[name] = { at: gl.getUniformLocation(program, name), type };
    }
    return { program, uniforms };
  }

  use(program, values) {
    const gl = this.gl;
    gl.useProgram(program.program);
    for (const [name, value] of Object.entries(values)) {
      const uniform = program.uniforms[name];
      if (!uniform) continue;
      if (uniform.type === gl.FLOAT_MAT4) gl.uniformMatrix4fv(uniform.at, false, value);
      else if (uniform.type === gl.FLOAT_VEC4) gl.uniform4fv(uniform.at, value);
      else if (uniform.type === gl.FLOAT_VEC3) gl.uniform3fv(uniform.at, value);
      else if (uniform.type === gl.FLOAT) gl.uniform1f(uniform.at, value);
      else gl.uniform1i(uniform.at, value);
    }
  }

  /** Brings a surface to the graphics card. */
  upload({ positions, normals, indices, edges }) {
    const gl = this.gl;
    const buffered = (target, data) => {
      gl.bindBuffer(target, gl.createBuffer());
      gl.bufferData(target, data, gl.STATIC_DRAW);
    };
    const attribute = (index, data) => {
      buffered(gl.ARRAY_BUFFER, new Float32Array(data));
      gl.enableVertexAttribArray(index);
      gl.vertexAttribPointer(index, 3, gl.FLOAT, false, 0, 0);
    };
    const faces = gl.createVertexArray();
    gl.bindVertexArray(faces);
    attribute(0, positions);
    attribute(1, normals);
    buffered(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(indices));
    const lines = gl.createVertexArray();
    gl.bindVertexArray(lines);
    attribute(0, edges);
    gl.bindVertexArray(null);
    return { faces, count: indices.length, lines, points: edges.length / 3 };
  }

  shadowTarget() {
    const gl = this.gl;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW_SIZE, SHADOW_SIZE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    const frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, texture, 0);
    gl.drawBuffers([gl.NONE]);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return { texture, frame };
  }

  /** The world as the light sees it: what is near the camera's target, or the whole scene. */
  shadowProjection() {
    const { camera } = this;
    const whole = camera.radius * 1.15;
    const half = Math.min(whole, camera.distance);
    const middle = half < whole ? camera.target : scale(add(camera.low, camera.high), 0.5);
    const eye = add(middle, scale(TO_LIGHT, 2 * whole));
    return multiply(parallel(half, 4 * whole), lookAt(eye, middle, [0, 1, 0]));
  }

  pickTarget() {
    const gl = this.gl;
    const [colour, depth, frame] = [gl.createRenderbuffer(), gl.createRenderbuffer(), gl.createFramebuffer()];
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    for (const [buffer, format, attachment] of [
      [colour, gl.RGBA8, gl.COLOR_ATTACHMENT0],
      [depth, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT],
    ]) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorage(gl.RENDERBUFFER, format, 1, 1);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, attachment, gl.RENDERBUFFER, buffer);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return frame;
  }

  /** Fits the drawing buffer to the canvas on the page. */
  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    const [width, height] = [clientWidth, clientHeight].map((size) => Math.max(1, Math.round(size * ratio)));
    if (this.canvas.width !== width || this.canvas.height !== height) [this.canvas.width, this.canvas.height] = [width, height];
    this.camera.viewport = [Math.max(1, clientWidth), Math.max(1, clientHeight)];
  }

  /** Draws `items`, and `paths` ({points, colour: [r, g, b, a]}) on top; `bare`: neither floor nor background. */
  draw(items, paths, bare = false) {
    const gl = this.gl;
    const solid = items.filter((item) => item.alpha >= 1);
    const clear = items.filter((item) => item.alpha < 1);
    const shadowProjection = this.shadowProjection();
    this.drawShadows(items.filter((item) => item.shadow), shadowProjection);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...(bare ? [1, 1, 1] : this.theme.background), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    const viewProjection = this.camera.viewProjection();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.shadow.texture);
    const common = { viewProjection, shadowProjection, shadowMap: 0, eye: this.camera.eye, toLight: TO_LIGHT };
    if (!bare) this.drawFloor(common);
    const light = { ...common, skyLight: this.theme.sky, groundLight: this.theme.ground };
    gl.enable(gl.POLYGON_OFFSET_FILL);
    for (const item of solid) {
      // Surfaces of neighbouring links may coincide: one of them is drawn behind.
      gl.polygonOffset(1 + (item.behind || 0), 1 + 8 * (item.behind || 0));
      this.drawFaces(this.surfaceProgram, item, light);
    }
    gl.disable(gl.POLYGON_OFFSET_FILL);
    this.drawEdges(solid, viewProjection);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE);
    gl.depthMask(false);
    const depth = (item) => this.camera.project([...item.matrix.slice(12, 15)], viewProjection)?.[2] ?? 0;
    for (const item of clear.sort((a, b) => depth(b) - depth(a))) this.drawFaces(this.surfaceProgram, item, light);
    this.drawEdges(clear, viewProjection);
    for (const path of paths) this.drawPath(path, viewProjection);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }

  drawShadows(items, viewProjection) {
    const gl = this.gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadow.frame);
    gl.viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1.5, 2);
    for (const item of items) this.drawFaces(this.flatProgram, item, { viewProjection, nearer: 0 });
    gl.disable(gl.POLYGON_OFFSET_FILL);
  }

  drawFloor(common) {
    const middle = scale(add(this.camera.low, this.camera.high), 0.5);
    const model = matrixOf([middle[0], middle[1], this.floor, 0, 0, 0, 1]);
    const { floor, line, background } = this.theme;
    this.use(this.floorProgram, { ...common, model, colour: floor, lineColour: line, background, middle, reach: this.groundReach });
    this.gl.bindVertexArray(this.ground.faces);
    this.gl.drawElements(this.gl.TRIANGLES, this.ground.count, this.gl.UNSIGNED_INT, 0);
  }

  drawFaces(program, item, values) {
    this.use(program, { ...values, model: item.matrix, colour: item.colour, alpha: item.alpha });
    this.gl.bindVertexArray(item.surface.faces);
    this.gl.drawElements(this.gl.TRIANGLES, item.surface.count, this.gl.UNSIGNED_INT, 0);
  }

  drawEdges(items, viewProjection) {
    for (const item of items) {
      if (!item.edges || !item.surface.points) continue;
      this.use(this.flatProgram, { viewProjection, model: item.matrix, paint: item.edges, nearer: 0.00002 });
      this.gl.bindVertexArray(item.surface.lines);
      this.gl.drawArrays(this.gl.LINES, 0, item.surface.points);
    }
  }

  drawPath({ points, colour }, viewProjection) {
    const gl = this.gl;
    this.use(this.flatProgram, { viewProjection, model: matrixOf(IDENTITY), paint: colour, nearer: 0.0001 });
    gl.bindVertexArray(this.lines.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.lines.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(points), gl.DYNAMIC_DRAW);
    gl.drawArrays(gl.LINE_STRIP, 0, points.length / 3);
  }

  /** The `id` of the item that is seen at a pixel of the viewport; undefined where there is none. */
  itemAt(items, x, y) {
    const gl = this.gl;
    const [width, height] = this.camera.viewport;
    // Enlarges that one pixel to the whole picture.
    const narrowed = new Float32Array([width, 0, 0, 0, 0, height, 0, 0, 0, 0, 1, 0, width - 2 * x - 1, 2 * y + 1 - height, 0, 1]);
    const viewProjection = multiply(narrowed, this.camera.viewProjection());
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.pick);
    gl.viewport(0, 0, 1, 1);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const pickable = items.filter((item) => item.id);
    pickable.forEach((item, i) => {
      const paint = [((i + 1) & 255) / 255, ((i + 1) >> 8) / 255, 0, 1];
      this.use(this.flatProgram, { viewProjection, model: item.matrix, paint, nearer: 0 });
      gl.bindVertexArray(item.surface.faces);
      gl.drawElements(gl.TRIANGLES, item.surface.count, gl.UNSIGNED_INT, 0);
    });
    const pixel = new Uint8Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return pickable[pixel[0] + 256 * pixel[1] - 1]?.id;
  }
}
