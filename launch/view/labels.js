// Names over the picture: placed where they do not cover one another, more important ones first.

/** Places to try, from a point to the label's corner, in sizes of the label. Robots stand on their names, regions' names hang. */
const PLACES = {
  above: [[-0.5, -1], [-0.5, -2.1], [0.1, -1.4], [-1.1, -1.4], [-0.5, 0.4], [-0.5, -3.2]],
  below: [[-0.5, 0.3], [0.4, 0], [-1.4, 0], [-0.5, 1.6], [0.6, -1.2], [-1.6, -1.2]],
};

class Labels {
  constructor(layer) {
    this.layer = layer;
    this.spans = [];
  }

  /** Shows `labels` ({text, at: [x, y], kind, colour}), in order of importance, within [width, height]. */
  show(labels, [width, height]) {
    const taken = [];
    labels.forEach((label, i) => {
      const span = this.span(i);
      const key = `${label.kind} ${label.text} ${label.colour}`;
      if (span.dataset.key !== key) {
        span.dataset.key = key;
        span.className = `label ${label.kind}`;
        span.textContent = label.text;
        span.style.setProperty("--own", label.colour || "transparent");
        span.size = undefined;
      }
      span.hidden = false;
      span.size ||= [span.offsetWidth, span.offsetHeight];
      const box = this.freePlace(label, span.size, taken, width, height);
      span.hidden = !box;
      if (!box) return;
      taken.push(box);
      span.style.transform = `translate(${Math.round(box[0])}px, ${Math.round(box[1])}px)`;
    });
    for (const span of this.spans.slice(labels.length)) span.hidden = true;
  }

  span(i) {
    if (!this.spans[i]) this.spans[i] = this.layer.appendChild(document.createElement("span"));
    return this.spans[i];
  }

  /** A box [left, top, right, bottom] near a point that is free; undefined where there is none. */
  freePlace({ at: [x, y], kind }, [w, h], taken, width, height) {
    for (const [dx, dy] of /^(robot|region)/.test(kind) ? PLACES.below : PLACES.above) {
      const [left, top] = [x + dx * w, y + dy * h];
      const box = [left, top, left + w, top + h];
      const inside = left >= 2 && top >= 2 && box[2] <= width - 2 && box[3] <= height - 2;
      const free = taken.every((other) => box[2] + 2 < other[0] || other[2] + 2 < box[0] || box[3] < other[1] || other[3] < box[1]);
      if (inside && free) return box;
    }
    return undefined;
  }
}
