// The panel beside the picture: figures of the plan or the failure, what each robot is doing, orderings, stages.

/** Adds an element with a class and text. */
function put(parent, tag, kind = "", text = undefined) {
  const element = document.createElement(tag);
  if (kind) element.className = kind;
  if (text !== undefined) element.textContent = text;
  return parent.appendChild(element);
}

function putSection(parent, title) {
  const section = put(parent, "section");
  put(section, "h2", "", title);
  return section;
}

function putFigure(parent, name, value, note = "") {
  const row = put(parent, "div", "figure");
  put(row, "dt", "", name);
  const data = put(row, "dd", "", value);
  if (note) put(data, "small", note.length > 16 ? "long" : "", note);
}

/** A table of each stage's work. */
function putStages(parent, stages) {
  if (!stages.length) return;
  const table = put(putSection(parent, "Stages"), "table");
  const head = put(put(table, "thead"), "tr");
  for (const name of ["stage", "jobs", "failed", "work"]) put(head, "th", "", name).scope = "col";
  const body = put(table, "tbody");
  for (const stage of stages) {
    const row = put(body, "tr");
    put(row, "th", "", stage.stage).scope = "row";
    for (const count of [stage.jobs, stage.failures, stage.work]) put(row, "td", "", count.toLocaleString("en"));
  }
}

function putProvenance(parent, data) {
  const list = put(putSection(parent, "Made from"), "dl");
  putFigure(list, "seed", String(data.provenance.seed));
  putFigure(list, "problem", `${data.provenance.problem_digest.slice(0, 12)}…`);
  putFigure(list, "ledger", `${data.provenance.ledger_digest.slice(0, 12)}…`);
  putFigure(list, "program", `mrtamp ${data.version}`);
}

/** The panel of a plan. */
class PlanPanel {
  constructor(element, data, world, { seek, follow }) {
    [this.world, this.plan, this.seek, this.follow] = [world, data.plan, seek, follow];
    this.putSummary(element);
    if (data.violations.length) {
      const list = put(putSection(element, "What the checker found"), "ul", "tried");
      for (const words of data.violations.slice(0, 20)) put(list, "li", "", words);
    }
    this.putRobots(element);
    this.putOrderings(element);
    putStages(element, data.stages);
    putProvenance(element, data);
  }

  putSummary(element) {
    const { task_s, total_s, bound_s, bound_kind, orderings, arcs } = this.plan;
    const section = putSection(element, "Plan");
    const list = put(section, "dl", "summary");
    putFigure(list, "makespan", `${task_s.toFixed(2)} s`, `all at rest ${total_s.toFixed(2)} s`);
    putFigure(list, "lower bound", `${bound_s.toFixed(2)} s`, bound_kind);
    const gap = bound_s > 0 ? ((task_s - bound_s) / bound_s) * 100 : undefined;
    putFigure(list, "gap", gap === undefined ? "–" : `${gap.toFixed(1)} %`);
    const discovered = orderings.filter((ordering) => ordering.discovered).length;
    putFigure(list, "orderings", `${orderings.length - discovered} given`, `${discovered} discovered`);
    putFigure(list, "arcs", String(arcs.length), "between robots");
  }

  putRobots(element) {
    const section = putSection(element, "Robots");
    this.rows = this.world.scene.robots.map((robot, i) => {
      const button = put(section, "button", "robot-row");
      button.type = "button";
      button.style.setProperty("--own", robot.colour);
      button.title = `follow ${robot.name}`;
      button.addEventListener("click", () => this.follow(i));
      put(button, "b", "", robot.name);
      const doing = put(button, "span", "doing");
      const { t, segments } = this.plan.robots[i];
      const waited = segments.filter((s) => s.kind === "wait").reduce((sum, s) => sum + t[s.to] - t[s.from], 0);
      put(button, "small", "", `moves ${(t[t.length - 1] - t[0] - waited).toFixed(1)} s, waits ${waited.toFixed(1)} s`);
      return { button, doing };
    });
  }

  putOrderings(element) {
    if (!this.plan.orderings.length) return;
    const list = put(putSection(element, "Orderings"), "ul", "orderings-list");
    const sorted = [...this.plan.orderings].sort((a, b) => b.discovered - a.discovered);
    for (const ordering of sorted) {
      const button = put(put(list, "li"), "button", ordering.discovered ? "discovered" : "given");
      button.type = "button";
      put(button, "em", "", ordering.discovered ? "discovered" : "given");
      put(button, "span", "", ordering.words);
      button.addEventListener("click", () => this.seek(ordering.before.t ?? 0));
    }
  }

  /** Says what each robot is doing. */
  show(t, following) {
    this.rows.forEach(({ button, doing }, robot) => {
      const words = this.activity(robot, t);
      if (doing.textContent !== words) doing.textContent = words;
      button.setAttribute("aria-pressed", String(robot === following));
    });
  }

  activity(robot, t) {
    const { segments, t: times } = this.plan.robots[robot];
    const segment = segments[this.world.segmentAt(robot, t)];
    if (!segment) return t < times[0] ? "not started" : "at rest";
    const pair = this.plan.pairs[segment.pair];
    const what = pair ? `${this.world.scene.objects[pair.object].name}` : "";
    return [segment.mode, what, "·", segment.kind].filter(Boolean).join(" ");
  }
}

/** The panel and the list of causes of a failure. */
class FailurePanel {
  constructor(element, causes, data, choose) {
    this.failure = data.failure;
    const section = putSection(element, "Result");
    put(section, "p", "headline", this.failure.headline);
    const tried = putSection(element, "What was tried");
    put(tried, "p", "", this.failure.tried.heading);
    const list = put(tried, "ul", "tried");
    for (const line of this.failure.tried.lines) put(list, "li", "", line);
    if (this.failure.remedies.length) {
      const advice = put(putSection(element, "What to try"), "ul", "tried");
      for (const words of this.failure.remedies) put(advice, "li", "", words);
    }
    putStages(element, data.stages);
    putProvenance(element, data);
    this.putCauses(causes, choose);
  }

  putCauses(element, choose) {
    this.buttons = new Map();
    const { causes } = this.failure;
    const headings = { proof: "Proof", task: "What could not be done, most frequent first", contact: "What was touched while trying, most frequent first" };
    for (const [name, heading] of Object.entries(headings)) {
      const group = causes.filter((cause) => cause.group === name);
      if (!group.length) continue;
      const section = put(element, "div", `group ${name}`);
      put(section, "h2", "", heading);
      const list = put(section, "ol", "causes");
      const most = Math.max(1, ...group.map((cause) => cause.count));
      for (const cause of group) {
        const button = put(put(list, "li"), "button", "cause");
        button.type = "button";
        button.style.setProperty("--share", `${(100 * cause.count) / most}%`);
        if (name !== "proof") put(button, "b", "", `${cause.count.toLocaleString("en")} ×`);
        put(button, "span", "", cause.words);
        button.addEventListener("click", () => choose(cause));
        this.buttons.set(cause, button);
      }
    }
    if (!causes.length) put(element, "h2", "", "No cause was recorded");
  }

  show(chosen) {
    for (const [cause, button] of this.buttons) button.setAttribute("aria-pressed", String(cause === chosen));
  }
}
