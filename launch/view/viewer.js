// Puts the page together: picture, controls, timeline, panel, keys; and `window.mrtamp` for programs that drive it.

const $ = (id) => document.getElementById(id);
const SPEEDS = [0.25, 1, 2, 4, 8];
const CULPRIT = colourOf("#d55e00");
const THEMES = {
  light: {
    fixed: 1, background: colourOf("#eef1f5"), floor: colourOf("#e3e7ec"), line: colourOf("#aeb7c2"),
    sky: [0.52, 0.54, 0.57], ground: [0.26, 0.25, 0.24], edge: [0.08, 0.1, 0.14, 0.5],
  },
  dark: {
    fixed: 0.55, background: colourOf("#10141a"), floor: colourOf("#1b212a"), line: colourOf("#3b4654"),
    sky: [0.40, 0.42, 0.46], ground: [0.16, 0.16, 0.17], edge: [0.02, 0.03, 0.05, 0.65],
  },
};

/** The box that names what the pointer is on. */
class Tip {
  constructor(element) {
    this.element = element;
  }

  show(lines, x, y) {
    this.element.replaceChildren();
    lines.forEach((line, i) => put(this.element, i ? "span" : "b", "", line));
    this.element.hidden = false;
    const { offsetWidth: width, offsetHeight: height } = this.element;
    const left = clamp(x + 14, 4, document.documentElement.clientWidth - width - 4);
    const top = y + 18 + height < window.innerHeight ? y + 18 : y - height - 12;
    this.element.style.transform = `translate(${left}px, ${Math.max(4, top)}px)`;
  }

  hide() {
    this.element.hidden = true;
  }
}

class Viewer {
  constructor(data) {
    this.data = data;
    this.world = new World(data);
    this.t = 0;
    this.speed = 1;
    this.playing = false;
    this.following = -1;
    this.shown = { labels: true, paths: true, glass: false };
    this.only = undefined;
    this.cause = data.failure && (data.failure.causes.find((cause) => cause.group !== "contact") || data.failure.causes[0]);
    this.tip = new Tip($("tip"));
    this.paths = new Map();
    this.labels = new Labels($("labels"));
    this.camera = new Camera(this.world.extent());
    this.prepareRenderer();
    this.prepareText();
    this.prepareControls();
    this.followTheme();
    new ResizeObserver(() => this.resized()).observe($("stage"));
    this.resized(true);
    window.addEventListener("hashchange", () => this.seekToHash());
    this.seekToHash();
  }

  prepareRenderer() {
    const lowest = Math.min(0, this.camera.low[2]);
    try {
      this.renderer = new Renderer(document.querySelector("canvas"), this.camera, lowest - 0.001);
    } catch (error) {
      $("fault").textContent = `There is no picture: ${error.message}`;
      $("fault").hidden = false;
      return;
    }
    this.surfaces = new Map();
    const owned = (owner, kind, extra) => owner.bodies.map((body) => this.item(body, { id: `${kind}:${owner.name}`, ...extra(owner) }));
    const { scene } = this.world;
    const fixedColour = colourOf(scene.colours.fixed);
    this.fixed = scene.fixed.flatMap((owner) => owned(owner, "fixed", (o) => ({ pose: o.pose, colour: fixedColour })));
    for (const item of this.fixed) {
      item.frame = compose(item.pose, item.body.pose);
      item.matrix = matrixOf(item.frame);
      item.corners = cornersOf(item.body);
    }
    this.objects = scene.objects.map((owner) => owned(owner, "object", () => ({ colour: colourOf(scene.colours.object) })));
    this.links = scene.robots.map((robot) => robot.links.map((link, i) => {
      const colour = mixed(colourOf(robot.colour), [1, 1, 1], i % 2 ? 0.42 : 0.06);
      return link.bodies.map((body) => this.item(body, { id: `link:${robot.name}/${link.name}`, colour, behind: i % 2 }));
    }));
    this.regions = scene.regions.map((region) => ({
      id: `region:${region.name}`,
      surface: this.renderer.upload(sheetSurface(region.size)),
      matrix: matrixOf(compose(region.pose, [0, 0, 0.002, 0, 0, 0, 1])),
      colour: colourOf(scene.colours.region), alpha: 0.42, edges: [...colourOf(scene.colours.region), 1], shadow: false,
    }));
    this.ghosts = this.objects.map((items) => items.map((item) => ({ ...item, id: undefined, alpha: 0.18, shadow: false })));
  }

  /** A body to be drawn; equal shapes share a surface. */
  item(body, extra) {
    const key = JSON.stringify([body.box, body.sphere, body.cylinder, body.capsule, body.hull]);
    if (!this.surfaces.has(key)) this.surfaces.set(key, this.renderer.upload(surfaceOf(body)));
    return { body, surface: this.surfaces.get(key), matrix: matrixOf(IDENTITY), alpha: 1, edges: true, shadow: true, ...extra };
  }

  prepareText() {
    const { data } = this;
    document.querySelector("h1").textContent = data.problem;
    if (data.plan) {
      document.body.className = "plan";
      const verdict = document.querySelector(".verdict");
      verdict.textContent = data.violations.length ? "refused by the checker" : "certified plan";
      verdict.classList.toggle("refused", data.violations.length > 0);
      const seek = (t) => this.seek(t, true);
      this.panel = new PlanPanel($("panel"), data, this.world, { seek, follow: (robot) => this.follow(robot) });
      this.timeline = new Timeline($("timeline"), this.world, this.tip, seek);
    } else {
      document.body.className = "failure";
      document.querySelector(".verdict").textContent = data.failure.headline;
      this.panel = new FailurePanel($("panel"), $("causes"), data, (cause) => this.choose(cause));
    }
  }

  prepareControls() {
    $("scrub").max = this.world.duration;
    $("scrub").addEventListener("input", () => this.seek(Number($("scrub").value), true));
    $("play").addEventListener("click", () => this.toggle());
    $("back").addEventListener("click", () => this.seek(0, true));
    for (const speed of SPEEDS) {
      const button = put($("speeds"), "button", "", speed === 0.25 ? "¼×" : `${speed}×`);
      button.type = "button";
      button.dataset.speed = speed;
      button.addEventListener("click", () => this.setSpeed(speed));
    }
    this.setSpeed(1);
    for (const button of document.querySelectorAll("[data-view]")) button.addEventListener("click", () => this.look(button.dataset.view));
    for (const button of document.querySelectorAll("[data-toggle]")) button.addEventListener("click", () => this.switch(button.dataset.toggle));
    $("help").addEventListener("click", () => $("keys").showModal());
    document.addEventListener("keydown", (event) => this.key(event));
    // A button that was clicked with a pointer does not keep the keys, least of all the space bar.
    document.addEventListener("click", (event) => event.detail && event.target.closest("button")?.blur());
    document.addEventListener("pointerdown", () => this.tip.hide());
    const canvas = document.querySelector("canvas");
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => location.reload());
    handleGestures(canvas, this.camera, () => {
      this.moved = true;
      this.tip.hide();
      this.invalidate();
    });
    canvas.addEventListener("dblclick", () => this.look("fit"));
    canvas.addEventListener("pointermove", (event) => this.pointAt(event));
    canvas.addEventListener("pointerleave", () => this.tip.hide());
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || $("keys").open) return;
    const inField = event.target instanceof HTMLInputElement && event.target.type === "checkbox";
    const onButton = event.target instanceof HTMLButtonElement;
    if (event.key === " " && (inField || onButton)) return;
    const step = event.shiftKey ? 5 : 0.5;
    const times = this.data.plan ? this.data.plan.events.map((e) => e.t) : [];
    const actions = {
      " ": () => this.toggle(),
      ArrowLeft: () => this.seek(this.t - step, true),
      ArrowRight: () => this.seek(this.t + step, true),
      Home: () => this.seek(0, true),
      End: () => this.seek(this.world.duration, true),
      ",": () => this.seek(times.findLast((t) => t < this.t - 1e-6) ?? 0, true),
      ".": () => this.seek(times.find((t) => t > this.t + 1e-6) ?? this.world.duration, true),
      r: () => this.look("fit"), t: () => this.look("top"),
      l: () => this.switch("labels"), p: () => this.switch("paths"), x: () => this.switch("glass"),
      0: () => this.setSpeed(0.25), 1: () => this.setSpeed(1), 2: () => this.setSpeed(2), 4: () => this.setSpeed(4), 8: () => this.setSpeed(8),
      "?": () => $("keys").showModal(),
    };
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  followTheme() {
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    const apply = (name) => {
      document.documentElement.dataset.theme = name;
      if (this.renderer) this.renderer.theme = THEMES[name];
      this.invalidate();
    };
    dark.addEventListener("change", () => apply(dark.matches ? "dark" : "light"));
    $("theme").addEventListener("click", () => apply(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
    apply(dark.matches ? "dark" : "light");
  }

  resized() {
    if (!this.renderer) return;
    this.renderer.resize();
    // Until the user has moved the camera, the scene stays framed.
    if (!this.moved) this.camera.frame();
    this.invalidate();
  }

  look(view) {
    this.following = -1;
    this.moved = false;
    if (view === "top") this.camera.frame(-Math.PI / 2, Math.PI / 2);
    else this.camera.frame();
    this.moved = view === "top";
    this.invalidate();
  }

  switch(name) {
    this.shown[name] = !this.shown[name];
    document.querySelector(`[data-toggle=${name}]`).setAttribute("aria-pressed", String(this.shown[name]));
    this.invalidate();
  }

  follow(robot) {
    this.following = this.following === robot ? -1 : robot;
    if (this.following >= 0) {
      this.moved = true;
      this.camera.target = add(this.world.linkPoses(robot, this.t)[0].slice(0, 3), [0, 0, 0.6]);
      this.camera.distance = Math.min(this.camera.distance, 4.5);
    }
    this.followed = undefined;
    this.invalidate();
  }

  choose(cause) {
    this.cause = this.cause === cause ? undefined : cause;
    this.invalidate();
  }

  setSpeed(speed) {
    this.speed = speed;
    for (const button of $("speeds").children) button.setAttribute("aria-pressed", String(Number(button.dataset.speed) === speed));
  }

  toggle() {
    if (!this.data.plan) return;
    if (!this.playing && this.t >= this.world.duration) this.seek(0);
    this.playing = !this.playing;
    this.lastFrame = undefined;
    this.showPlaying();
    if (!this.playing) this.remember();
    this.invalidate();
  }

  showPlaying() {
    $("play").classList.toggle("playing", this.playing);
    $("play").setAttribute("aria-label", this.playing ? "pause" : "play");
  }

  /** Goes to a time (s); `noted`: and puts it into the address. */
  seek(t, noted = false) {
    this.t = clamp(Number.isFinite(t) ? t : 0, 0, this.world.duration);
    this.lastFrame = undefined;
    if (noted && !this.playing) this.remember();
    this.invalidate();
  }

  /** Puts the time into the page's address, so that it can be shared and survives a reload. */
  remember() {
    clearTimeout(this.remembering);
    this.remembering = setTimeout(() => history.replaceState(null, "", `#t=${this.t.toFixed(2)}`), 200);
  }

  seekToHash() {
    const found = /[#&]t=([0-9.]+)/.exec(location.hash);
    if (found) this.seek(Number(found[1]));
  }

  invalidate() {
    if (!this.scheduled) this.scheduled = requestAnimationFrame((now) => this.frame(now));
  }

  frame(now) {
    this.scheduled = 0;
    if (this.playing) {
      if (this.lastFrame !== undefined) this.t = Math.min(this.world.duration, this.t + ((now - this.lastFrame) / 1000) * this.speed);
      this.lastFrame = now;
      if (this.t >= this.world.duration) {
        this.playing = false;
        this.showPlaying();
        this.remember();
      }
    }
    this.showTime();
    if (this.renderer) this.showPicture();
    window.mrtamp.ready = true;
    if (this.playing) this.invalidate();
  }

  showTime() {
    if (!this.data.plan) return this.panel.show(this.cause);
    $("clock").textContent = `${this.t.toFixed(1)} / ${this.world.duration.toFixed(1)} s`;
    $("scrub").value = this.t;
    const slider = document.querySelector(".scroll");
    const values = { valuemin: 0, valuemax: this.world.duration.toFixed(2), valuenow: this.t.toFixed(2), valuetext: `${this.t.toFixed(1)} s` };
    for (const [name, value] of Object.entries(values)) slider.setAttribute(`aria-${name}`, value);
    this.timeline.show(this.t, this.playing);
    this.panel.show(this.t, this.following);
  }

  showPicture() {
    const state = this.world.at(this.t);
    this.state = state;
    if (this.following >= 0) {
      const root = state.links[this.following][0].slice(0, 3);
      if (this.followed) this.camera.target = add(this.camera.target, subtract(root, this.followed));
      this.followed = root;
    }
    const items = this.items(state);
    const bare = this.only !== undefined;
    this.drawn = bare ? items.filter((item) => this.only.includes(item.id)) : items;
    this.renderer.draw(this.drawn, bare || !this.shown.paths || !this.data.plan ? [] : this.currentPaths(), bare);
    this.labels.show(bare || !this.shown.labels ? [] : this.labelsOf(state), this.camera.viewport);
  }

  items(state) {
    const items = [...this.fixed, ...this.regions];
    state.links.forEach((poses, robot) => poses.forEach((pose, link) => {
      for (const item of this.links[robot][link]) {
        item.matrix = matrixOf(compose(pose, item.body.pose));
        items.push(item);
      }
    }));
    state.objects.forEach((pose, object) => {
      for (const item of this.objects[object]) {
        item.matrix = matrixOf(compose(pose, item.body.pose));
        items.push(item);
      }
      const next = this.data.plan && state.holders[object] >= 0 && this.world.nextPlace(object, this.t);
      for (const ghost of next ? this.ghosts[object] : []) {
        ghost.matrix = matrixOf(compose(next, ghost.body.pose));
        items.push(ghost);
      }
    });
    const hiding = this.hiding(state);
    return items.map((item) => this.painted(item, hiding));
  }

  /** Names of fixed objects that stand between the eye and a hand or an object. */
  hiding(state) {
    const eye = this.camera.eye;
    const hands = state.links.map((poses, robot) => this.world.toolPose(robot, poses));
    const seen = [...hands, ...state.objects].map((pose) => pose.slice(0, 3));
    return new Set(this.fixed.filter((item) => seen.some((point) => crossesBounds(eye, point, item))).map((item) => item.id));
  }

  /** An item in the colours of the moment: theme, glass, culprits. */
  painted(item, hiding) {
    const { edge, fixed } = this.renderer.theme;
    let { colour, alpha } = item;
    let edges = item.edges === true ? edge : item.edges;
    if (item.id?.startsWith("fixed:")) {
      colour = scale(colour, fixed);
      if (this.shown.glass || hiding.has(item.id)) [alpha, edges] = [this.shown.glass ? 0.16 : 0.3, [...edge.slice(0, 3), 0.6]];
    }
    if (this.data.failure) {
      const blame = this.blame(item.id);
      if (blame === 2) [colour, alpha, edges] = [CULPRIT, Math.max(alpha, 0.7), [0, 0, 0, 1]];
      else if (blame === 1) colour = mixed(colour, CULPRIT, 0.4);
      else if (!item.id?.startsWith("region:")) colour = mixed(mixed(colour, [0.62, 0.65, 0.7], 0.75), this.renderer.theme.background, 0.15);
    }
    return { ...item, colour, alpha, edges };
  }

  /** 2 if the chosen cause names a body (any cause, where none is chosen), 1 if only another cause does, else 0. */
  blame(id) {
    const { causes } = this.data.failure;
    const names = (cause) => cause.bodies.some((body) => body === id || (body.startsWith("robot:") && id?.startsWith(`link:${body.slice(6)}/`)));
    if (this.cause ? names(this.cause) : causes.some(names)) return 2;
    return causes.some(names) ? 1 : 0;
  }

  /** The way of each hand in its robot's current mode: what is over darker, what is to come fainter. */
  currentPaths() {
    return this.world.scene.robots.flatMap((robot, i) => {
      const mode = this.timeline.modes[i].findLast((mode) => mode.begins <= this.t);
      if (!mode || this.t > mode.ends) return [];
      const key = `${i} ${mode.from}`;
      if (!this.paths.has(key)) this.paths.set(key, this.handPath(i, mode));
      const { times, points } = this.paths.get(key);
      const now = this.world.toolPose(i, this.state.links[i]).slice(0, 3);
      const split = lastAt(times, this.t) + 1;
      const colour = mixed(colourOf(robot.colour), this.renderer.theme === THEMES.dark ? [1, 1, 1] : [0, 0, 0], 0.15);
      return [
        { points: [...points.slice(0, split).flat(), ...now], colour: [...colour, 0.9] },
        { points: [...now, ...points.slice(split).flat()], colour: [...colour, 0.45] },
      ];
    });
  }

  handPath(robot, mode) {
    const steps = Math.ceil(clamp((mode.ends - mode.begins) * 15, 8, 240));
    const times = Array.from({ length: steps + 1 }, (_, i) => mode.begins + ((mode.ends - mode.begins) * i) / steps);
    return { times, points: times.map((t) => this.world.toolPose(robot, this.world.linkPoses(robot, t)).slice(0, 3)) };
  }

  labelsOf(state) {
    const { scene } = this.world;
    const matrix = this.camera.viewProjection();
    const label = (text, point, kind, colour, id) => {
      const at = this.camera.project(point, matrix);
      const blame = this.data.failure && this.blame(id) === 2;
      return at && { text: blame ? `! ${text}` : text, at, kind: blame ? `${kind} blamed` : kind, colour };
    };
    const robots = scene.robots.map((robot, i) => label(robot.name, state.links[i][0], "robot", robot.colour, `link:${robot.name}/${robot.links[0].name}`));
    const objects = scene.objects.map((object, i) => label(object.name, add(state.objects[i], [0, 0, this.halfHeight(i)]), "object", "", `object:${object.name}`));
    const regions = scene.regions.map((region) => label(region.name, placed(region.pose, [0, -region.size[1] / 2, 0]), "region", scene.colours.region, `region:${region.name}`));
    const links = this.data.failure && this.cause ? this.cause.bodies.filter((body) => body.startsWith("link:")).map((body) => label(body.slice(body.indexOf("/") + 1), this.poseOf(body), "link", "", body)) : [];
    const fixed = this.data.failure ? scene.fixed.filter((o) => this.blame(`fixed:${o.name}`) === 2).map((o) => label(o.name, o.pose, "fixed", "", `fixed:${o.name}`)) : [];
    return [...links, ...robots, ...objects, ...fixed, ...regions].filter(Boolean);
  }

  halfHeight(object) {
    const corners = this.world.scene.objects[object].bodies.flatMap((body) => cornersOf(body).map((corner) => placed(body.pose, corner)[2]));
    return Math.max(...corners) + 0.02;
  }

  /** Names what is under the pointer. */
  pointAt(event) {
    if (!this.renderer || event.buttons || event.pointerType === "touch" || !this.drawn) return;
    const box = event.currentTarget.getBoundingClientRect();
    cancelAnimationFrame(this.pointing);
    const [x, y] = [event.clientX, event.clientY];
    this.pointing = requestAnimationFrame(() => {
      const id = this.renderer.itemAt(this.drawn.filter((item) => item.alpha > 0.3), x - box.left, y - box.top);
      if (id) this.tip.show(this.bodyWords(id), x, y);
      else this.tip.hide();
    });
  }

  bodyWords(id) {
    const [kind, name] = [id.slice(0, id.indexOf(":")), id.slice(id.indexOf(":") + 1)];
    const coordinates = ([x, y, z]) => `${x.toFixed(3)}, ${y.toFixed(3)}, ${z.toFixed(3)} m`;
    const lines = [kind === "link" ? name.replace("/", " ") : name, `${{ link: "link", object: "object", fixed: "fixed", region: "region" }[kind]} at ${coordinates(this.poseOf(id))}`];
    const object = kind === "object" ? this.world.scene.objects.findIndex((o) => o.name === name) : -1;
    if (object >= 0 && this.state.holders[object] >= 0) lines.push(`held by ${this.world.scene.robots[this.state.holders[object]].name}`);
    return lines;
  }

  /** Pose of `link:<robot>/<link>`, `robot:<name>`, `object:<name>`, `fixed:<name>`, `region:<name>`, or of a bare name. */
  poseOf(id) {
    const { scene } = this.world;
    const state = this.world.at(this.t);
    const poses = new Map();
    const know = (kind, name, pose) => {
      poses.set(`${kind}:${name}`, pose);
      if (!poses.has(name)) poses.set(name, pose);
    };
    scene.robots.forEach((robot, i) => {
      know("robot", robot.name, state.links[i][0]);
      robot.links.forEach((link, j) => know("link", `${robot.name}/${link.name}`, state.links[i][j]));
    });
    scene.objects.forEach((object, i) => know("object", object.name, state.objects[i]));
    for (const kind of ["fixed", "region"]) for (const one of scene[kind === "fixed" ? "fixed" : "regions"]) know(kind, one.name, one.pose);
    return poses.get(id);
  }

  /** Where the origin of a named frame is on the page (px). */
  project(id) {
    const pose = this.poseOf(id);
    const at = pose && this.camera.project(pose);
    if (!at) return undefined;
    const box = document.querySelector("canvas").getBoundingClientRect();
    return [box.left + at[0], box.top + at[1]];
  }

  /** What programs may do with the page. */
  interface() {
    const viewer = this;
    return {
      ready: false,
      duration: viewer.world.duration,
      seek: (t) => viewer.seek(t),
      time: () => viewer.t,
      playing: () => viewer.playing,
      speed: () => viewer.speed,
      project: (name) => viewer.project(name),
      /** Draws only the bodies with these ids (`object:m1`, `link:r1/hand`), on white; all again without argument. */
      only: (ids) => {
        viewer.only = ids;
        viewer.invalidate();
      },
      look: (view) => viewer.look(view),
      /** Eye, target and up (m, world), vertical field of view (rad), and the picture's box on the page (px). */
      camera: () => {
        const { left, top, width, height } = document.querySelector("canvas").getBoundingClientRect();
        const { eye, target, up } = viewer.camera;
        return { eye, target, up, fovY: FIELD_OF_VIEW, left, top, width, height };
      },
    };
  }
}

window.mrtamp = { ready: false };
const viewer = new Viewer(JSON.parse($("data").textContent));
window.mrtamp = viewer.interface();
