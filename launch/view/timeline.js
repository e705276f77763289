// The plan over time: a lane per robot and per object, orderings and dependency arcs between them, a playhead.

const AXIS = 24;
const LANE = { marks: 11, bar: 22, kinds: 9, gap: 22 };
const LANE_HEIGHT = LANE.marks + LANE.bar + 2 + LANE.kinds;
const OBJECT_LANE = { bar: 14, gap: 4 };
/** A wait that ends within this time (s) of an arc's first end is due to it. */
const BINDING = 2e-3;

const seconds = (t) => `${t.toFixed(2)} s`;

/** Adds an SVG element with attributes. */
function draw(parent, tag, attributes = {}, text = undefined) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  if (text !== undefined) element.textContent = text;
  return parent.appendChild(element);
}

/** Stretches of one robot with the same pair and mode: {robot, pair, mode, from, to, begins, ends}. */
function modesOf(plan, robot) {
  const { t, segments } = plan.robots[robot];
  const modes = [];
  for (const segment of segments) {
    const last = modes[modes.length - 1];
    const same = last && last.mode === segment.mode && (last.pair === segment.pair || segment.mode === "return");
    if (same) {
      [last.to, last.ends] = [segment.to, t[segment.to]];
    } else {
      const { pair, mode, from, to } = segment;
      modes.push({ robot, pair, mode, from, to, begins: t[from], ends: t[to] });
    }
  }
  return modes;
}

class Timeline {
  /** `seek(t)` is called when the user points at a time. */
  constructor(section, world, tip, seek) {
    [this.world, this.plan, this.tip, this.seek] = [world, world.plan, tip, seek];
    this.names = section.querySelector(".names");
    this.scroll = section.querySelector(".scroll");
    this.svg = this.scroll.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "svg"));
    this.modes = this.plan.robots.map((_, robot) => modesOf(this.plan, robot));
    this.zoom = 1;
    this.t = 0;
    this.shown = { orderings: true, arcs: true };
    this.arcs = this.plan.arcs.map((arc) => this.describeArc(arc));
    this.height = AXIS + this.plan.robots.length * (LANE_HEIGHT + LANE.gap)
      + world.scene.objects.length * (OBJECT_LANE.bar + OBJECT_LANE.gap) + 4;
    this.rebuild();
    this.listen(section);
    new ResizeObserver(() => this.rebuild()).observe(this.scroll);
  }

  describeArc([before, beforeKnot, after, afterKnot]) {
    const [first, later] = [this.plan.robots[before], this.plan.robots[after]];
    const [from, to] = [first.t[beforeKnot], later.t[afterKnot]];
    const waits = later.segments.some((segment) => segment.kind === "wait" && segment.to === afterKnot);
    return { before, beforeKnot, after, afterKnot, from, to, binding: waits && to - from < BINDING };
  }

  x(t) {
    return this.pad + (t / (this.world.duration || 1)) * (this.width - 2 * this.pad);
  }

  timeAt(x) {
    return clamp((x - this.pad) / (this.width - 2 * this.pad), 0, 1) * this.world.duration;
  }

  laneTop(robot) {
    return AXIS + robot * (LANE_HEIGHT + LANE.gap);
  }

  objectTop(object) {
    return AXIS + this.plan.robots.length * (LANE_HEIGHT + LANE.gap) + object * (OBJECT_LANE.bar + OBJECT_LANE.gap);
  }

  rebuild() {
    const room = this.scroll.clientWidth;
    // On a narrow page the lanes are wider than the page and scroll.
    const least = Math.min(12 * this.world.duration, 900);
    const width = Math.round(Math.max(room, least) * this.zoom);
    if (width === this.width) return;
    this.width = width;
    this.pad = 10;
    this.svg.replaceChildren();
    for (const [name, value] of Object.entries({ width, height: this.height, viewBox: `0 0 ${width} ${this.height}` })) {
      this.svg.setAttribute(name, value);
    }
    this.defineMarks();
    this.drawAxis();
    this.drawArcs();
    this.plan.robots.forEach((_, robot) => this.drawRobot(robot));
    this.world.scene.objects.forEach((_, object) => this.drawObject(object));
    this.drawOrderings();
    this.drawPlayhead();
    this.drawNames();
    this.show(this.t);
  }

  defineMarks() {
    const definitions = draw(this.svg, "defs");
    const hatch = draw(definitions, "pattern", { id: "hatch", width: 5, height: 5, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" });
    draw(hatch, "line", { x1: 1, y1: 0, x2: 1, y2: 5, class: "hatch" });
    for (const kind of ["given", "discovered", "arc"]) {
      const marker = draw(definitions, "marker", { id: `tip-${kind}`, viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 7, markerHeight: 7, orient: "auto" });
      draw(marker, "path", { d: "M0 0 L8 4 L0 8 Z", class: `tip-${kind}` });
    }
  }

  drawAxis() {
    const perSecond = (this.width - 2 * this.pad) / (this.world.duration || 1);
    const step = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500].find((step) => step * perSecond >= 64) || 1000;
    const bottom = this.height;
    for (let i = 0; i * step <= this.world.duration; i++) {
      const x = this.x(i * step);
      draw(this.svg, "line", { x1: x, x2: x, y1: AXIS - 6, y2: bottom, class: "tick" });
      draw(this.svg, "text", { x, y: AXIS - 10, class: "time", "text-anchor": i ? "middle" : "start" }, `${+(i * step).toFixed(1)}${i ? "" : " s"}`);
    }
    const limits = [["bound", this.plan.bound_s, `lower bound (${this.plan.bound_kind})`], ["makespan", this.plan.task_s, "makespan: task done"]];
    for (const [kind, t, words] of limits) {
      if (!(t > 0 && t <= this.world.duration)) continue;
      const line = draw(this.svg, "line", { x1: this.x(t), x2: this.x(t), y1: AXIS - 8, y2: bottom, class: `limit ${kind}` });
      line.tip = () => [words, seconds(t)];
      draw(this.svg, "path", { d: `M${this.x(t)} ${AXIS - 1} l-4 -7 h8 Z`, class: `limit-head ${kind}` }).tip = line.tip;
    }
  }

  drawRobot(robot) {
    const top = this.laneTop(robot) + LANE.marks;
    const colour = this.world.scene.robots[robot].colour;
    const lane = draw(this.svg, "g", { class: "lane" });
    lane.style.setProperty("--own", colour);
    lane.style.setProperty("--ink", inkOn(colour));
    for (const mode of this.modes[robot]) {
      const [x, width] = [this.x(mode.begins), this.x(mode.ends) - this.x(mode.begins)];
      const bar = draw(lane, "rect", { x: x + 0.5, y: top, width: Math.max(1, width - 1), height: LANE.bar, rx: 3, class: `mode ${mode.mode}` });
      bar.tip = () => this.modeWords(mode);
    }
    for (const segment of this.plan.robots[robot].segments) this.drawSegment(lane, robot, segment, top);
    for (const mode of this.modes[robot]) {
      const [x, end] = [this.x(mode.begins), this.x(mode.ends)];
      const text = this.fittingName(mode, end - x - 8);
      if (text) draw(lane, "text", { x: (x + end) / 2, y: top + 15, class: `name ${mode.mode}` }, text);
    }
    for (const event of this.world.gripping[robot]) {
      const [x, y] = [this.x(event.t), top - 2];
      const path = event.attach ? `M${x - 5} ${y - 8} h10 l-5 8 Z` : `M${x - 5} ${y} h10 l-5 -8 Z`;
      const pair = this.plan.pairs[event.pair];
      const object = this.world.scene.objects[event.object].name;
      draw(lane, "path", { d: path, class: `grip ${event.attach ? "attach" : "detach"}` }).tip = () => [
        `${event.attach ? "attach" : "detach"} ${object}`,
        `${pair.name}, ${event.attach ? `from ${pair.from}` : `in ${pair.to}`}`,
        seconds(event.t),
      ];
    }
  }

  /** What a robot does within a mode: a low bar for driving, ramps for reach and retract, dots for waiting. */
  drawSegment(lane, robot, segment, top) {
    const { t } = this.plan.robots[robot];
    const [x, end] = [this.x(t[segment.from]), this.x(t[segment.to])];
    if (!(end > x)) return;
    const [high, low] = [top + LANE.bar + 2, top + LANE.bar + 2 + LANE.kinds];
    const shapes = {
      base: `M${x} ${low} V${low - 3} H${end} V${low} Z`,
      reach: `M${x} ${low} L${end} ${high} V${low} Z`,
      retract: `M${x} ${high} L${end} ${low} H${x} Z`,
      wait: `M${x} ${low - 1} H${end}`,
    };
    if (segment.kind === "wait") draw(lane, "rect", { x, y: top, width: end - x, height: LANE.bar, class: "waiting" }).tip = () => this.segmentWords(robot, segment);
    draw(lane, "path", { d: shapes[segment.kind], class: `kind ${segment.kind}` });
    draw(lane, "rect", { x, y: high - 1, width: end - x, height: LANE.kinds + 2, class: "hit" }).tip = () => this.segmentWords(robot, segment);
  }

  drawObject(object) {
    const top = this.objectTop(object);
    const lane = draw(this.svg, "g", { class: "object-lane" });
    const name = this.world.scene.objects[object].name;
    const handling = this.world.handling[object];
    const region = (i) => {
      const [before, next] = [handling[i - 1], handling[i]];
      return before ? this.plan.pairs[before.pair].to : next ? this.plan.pairs[next.pair].from : "";
    };
    for (let i = 0; i <= handling.length; i++) {
      const begins = i ? handling[i - 1].t : 0;
      const ends = i < handling.length ? handling[i].t : this.world.duration;
      const holder = i && handling[i - 1].attach ? this.world.scene.robots[handling[i - 1].robot] : undefined;
      const text = holder ? holder.name : region(i);
      const [x, width] = [this.x(begins), this.x(ends) - this.x(begins)];
      const bar = draw(lane, "rect", { x: x + 0.5, y: top, width: Math.max(1, width - 1), height: OBJECT_LANE.bar, rx: 2, class: holder ? "held" : "stands" });
      bar.style.setProperty("--own", holder ? holder.colour : "transparent");
      bar.tip = () => [holder ? `${name} held by ${holder.name}` : `${name} stands in ${text}`, `${seconds(begins)} to ${seconds(ends)}`];
      if (text.length * 6.4 + 6 < width) {
        const label = draw(lane, "text", { x: x + width / 2, y: top + 11, class: holder ? "name held" : "name stands" }, text);
        if (holder) label.style.setProperty("--ink", inkOn(holder.colour));
      }
    }
  }

  /** A curve from the lane of one robot to another's. */
  curve(before, from, after, to) {
    const [x1, x2] = [this.x(from), this.x(to)];
    const down = after > before;
    const y1 = this.laneTop(before) + (down ? LANE_HEIGHT + 1 : 0);
    const y2 = this.laneTop(after) + (down ? -1 : LANE_HEIGHT + 2);
    const bend = (y2 - y1) * 0.55;
    return `M${x1} ${y1} C${x1} ${y1 + bend} ${x2} ${y2 - bend} ${x2} ${y2}`;
  }

  drawArcs() {
    const group = draw(this.svg, "g", { class: "arcs" });
    for (const arc of this.arcs) {
      const d = this.curve(arc.before, arc.from, arc.after, arc.to);
      const both = draw(group, "g", { class: arc.binding ? "arc binding" : "arc" });
      draw(both, "path", { d, class: "line", ...(arc.binding && { "marker-end": "url(#tip-arc)" }) });
      draw(both, "path", { d, class: "hit" }).tip = () => this.arcWords(arc);
    }
  }

  drawOrderings() {
    const group = draw(this.svg, "g", { class: "orderings" });
    for (const ordering of this.plan.orderings) {
      const [before, after] = [ordering.before, ordering.after];
      if (typeof before.t !== "number" || typeof after.t !== "number") continue;
      const [first, later] = [this.plan.pairs[before.pair].robot, this.plan.pairs[after.pair].robot];
      if (first === later) continue;
      const kind = ordering.discovered ? "discovered" : "given";
      const d = this.curve(first, before.t, later, after.t);
      const both = draw(group, "g", { class: `ordering ${kind}` });
      draw(both, "path", { d, class: "line", "marker-end": `url(#tip-${kind})` });
      draw(both, "path", { d, class: "hit" }).tip = () => [
        `${kind} ordering`, ordering.words, `${seconds(before.t)}, then ${seconds(after.t)}`,
      ];
    }
  }

  drawPlayhead() {
    this.playhead = draw(this.svg, "g", { class: "playhead" });
    draw(this.playhead, "line", { x1: 0, x2: 0, y1: 4, y2: this.height });
    draw(this.playhead, "path", { d: "M-6 2 h12 v6 l-6 7 l-6 -7 Z" });
  }

  drawNames() {
    this.names.replaceChildren();
    this.names.style.height = `${this.height}px`;
    const put = (text, top, height, kind, colour) => {
      const name = this.names.appendChild(document.createElement("div"));
      [name.textContent, name.className, name.title] = [text, kind, text];
      Object.assign(name.style, { top: `${top}px`, height: `${height}px`, lineHeight: `${height}px` });
      name.style.setProperty("--own", colour);
    };
    this.world.scene.robots.forEach(({ name, colour }, robot) => put(name, this.laneTop(robot) + LANE.marks, LANE.bar, "robot", colour));
    this.world.scene.objects.forEach(({ name }, object) => put(name, this.objectTop(object), OBJECT_LANE.bar, "object", this.world.scene.colours.object));
  }

  fittingName(mode, width) {
    if (mode.pair === undefined) return width > 44 ? "return" : "";
    const pair = this.plan.pairs[mode.pair];
    const object = this.world.scene.objects[pair.object].name;
    const long = mode.mode === "transfer" ? `${pair.name}: ${object} to ${pair.to}` : `${pair.name}: to ${object}`;
    const names = mode.mode === "return" ? ["return"] : this.isOver(mode) ? [pair.name] : [long, `${pair.name} ${object}`, pair.name, object];
    return names.find((name) => name.length * 6.3 <= width) || "";
  }

  modeWords(mode) {
    const span = `${seconds(mode.begins)} to ${seconds(mode.ends)} (${seconds(mode.ends - mode.begins)})`;
    const robot = this.world.scene.robots[mode.robot].name;
    if (mode.pair === undefined) return [`${robot} ${mode.mode}`, span];
    const pair = this.plan.pairs[mode.pair];
    const object = this.world.scene.objects[pair.object].name;
    const over = `${object} is in ${pair.to}; the arm comes back`;
    const transit = this.isOver(mode) ? over : `empty-handed, to take ${object} from ${pair.from}`;
    const what = { transit, transfer: `brings ${object} from ${pair.from} to ${pair.to}`, return: over };
    return [`${pair.name} ${mode.mode}`, what[mode.mode], span];
  }

  /** Whether a mode's pair has released its object before: the arm only comes back. */
  isOver(mode) {
    return this.plan.events.some((event) => event.pair === mode.pair && !event.attach && event.t <= mode.begins);
  }

  segmentWords(robot, segment) {
    const { t } = this.plan.robots[robot];
    const verbs = { base: "the base drives", reach: "the arm reaches", retract: "the arm retracts", wait: "waits" };
    const whose = segment.pair === undefined ? this.world.scene.robots[robot].name : this.plan.pairs[segment.pair].name;
    const [begins, ends] = [t[segment.from], t[segment.to]];
    const lines = [`${whose} ${segment.mode}: ${verbs[segment.kind]}`, `${seconds(begins)} to ${seconds(ends)} (${seconds(ends - begins)}), knots ${segment.from} to ${segment.to}`];
    const due = this.arcs.filter((arc) => arc.binding && arc.after === robot && arc.afterKnot === segment.to);
    if (segment.kind === "wait" && due.length) lines.push(`until ${due.map((arc) => `${this.robotName(arc.before)} has reached knot ${arc.beforeKnot}`).join(", ")}`);
    return lines;
  }

  arcWords(arc) {
    return [
      `${this.robotName(arc.before)} before ${this.robotName(arc.after)}`,
      `${this.robotName(arc.after)} may leave knot ${arc.afterKnot} (${seconds(arc.to)}) only once ${this.robotName(arc.before)} has reached knot ${arc.beforeKnot} (${seconds(arc.from)})`,
      arc.binding ? "binding: the robot waits for it" : `${seconds(arc.to - arc.from)} to spare`,
    ];
  }

  robotName(robot) {
    return this.world.scene.robots[robot].name;
  }

  listen(section) {
    const point = (event) => this.timeAt(event.clientX - this.svg.getBoundingClientRect().left);
    let dragging = false;
    this.svg.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      // A finger scrolls; its tap is a click.
      dragging = event.pointerType !== "touch";
      if (dragging) {
        this.svg.setPointerCapture(event.pointerId);
        this.seek(point(event));
      }
    });
    this.svg.addEventListener("click", (event) => {
      this.seek(point(event));
      this.hover(event);
    });
    this.svg.addEventListener("pointermove", (event) => {
      if (dragging) this.seek(point(event));
      this.hover(event);
    });
    for (const end of ["pointerup", "pointercancel"]) this.svg.addEventListener(end, () => (dragging = false));
    this.svg.addEventListener("pointerleave", () => this.tip.hide());
    this.scroll.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      this.zoomBy(event.deltaY < 0 ? 1.25 : 0.8, event.clientX - this.scroll.getBoundingClientRect().left);
    }, { passive: false });
    section.querySelector(".nearer").addEventListener("click", () => this.zoomBy(1.5));
    section.querySelector(".farther").addEventListener("click", () => this.zoomBy(1 / 1.5));
    for (const kind of ["orderings", "arcs"]) {
      const box = section.querySelector(`input[name=${kind}]`);
      box.addEventListener("change", () => this.svg.classList.toggle(`no-${kind}`, !box.checked));
    }
  }

  hover(event) {
    // While dragging, the pointer is captured by the whole picture.
    const target = document.elementFromPoint(event.clientX, event.clientY);
    if (target?.tip) this.tip.show(target.tip(), event.clientX, event.clientY);
    else this.tip.hide();
  }

  /** Stretches time about a place of the visible part. */
  zoomBy(factor, x = this.scroll.clientWidth / 2) {
    const t = this.timeAt(this.scroll.scrollLeft + x);
    this.zoom = clamp(this.zoom * factor, 1, 40);
    this.rebuild();
    this.scroll.scrollLeft = this.x(t) - x;
  }

  /** Moves the playhead; `follow`: and keeps it in view. */
  show(t, follow = false) {
    this.t = t;
    const x = this.x(t);
    this.playhead.setAttribute("transform", `translate(${x} 0)`);
    const [left, room] = [this.scroll.scrollLeft, this.scroll.clientWidth];
    if (follow && (x < left + 20 || x > left + room - 20)) this.scroll.scrollLeft = x - 0.25 * room;
  }
}

/** Black or white, whichever is easier to read on a colour. */
function inkOn(hex) {
  const [r, g, b] = colourOf(hex).map((c) => c ** 2.2);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b > 0.3 ? "#10151c" : "#ffffff";
}
