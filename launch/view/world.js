// Where everything is at a time: forward kinematics, and objects in hands.

class World {
  constructor(data) {
    this.scene = data.scene;
    this.plan = data.plan;
    this.duration = data.plan ? Math.max(0, ...data.plan.robots.map((robot) => robot.t[robot.t.length - 1])) : 0;
    const events = data.plan ? data.plan.events : [];
    this.handling = this.scene.objects.map((_, object) => events.filter((event) => event.object === object));
    this.gripping = this.scene.robots.map((_, robot) => events.filter((event) => event.robot === robot));
  }

  /** Coordinates of a robot, linear between its knots. */
  configuration(robot, t) {
    if (!this.plan) return this.scene.robots[robot].start;
    const { t: times, q } = this.plan.robots[robot];
    const last = lastAt(times, t);
    if (last < 0) return q[0];
    if (last + 1 >= times.length) return q[last];
    const part = (t - times[last]) / (times[last + 1] - times[last]);
    return q[last].map((value, i) => value + (q[last + 1][i] - value) * part);
  }

  /** Gap between a robot's fingers (m). */
  opening(robot, t) {
    const last = this.gripping[robot].findLast((event) => event.t <= t);
    return last && last.attach ? last.opening : this.scene.robots[robot].max_opening;
  }

  /** Poses of a robot's links in the world. */
  linkPoses(robot, t) {
    const tree = this.scene.robots[robot];
    const q = this.configuration(robot, t);
    const opening = this.opening(robot, t);
    const poses = tree.links.map(() => IDENTITY);
    poses[0] = tree.planar ? compose(tree.base, [q[0], q[1], 0, 0, 0, Math.sin(q[2] / 2), Math.cos(q[2] / 2)]) : tree.base;
    for (const joint of tree.joints) {
      const driver = joint.opening ? opening : joint.coordinate === undefined ? 0 : q[joint.coordinate];
      const value = joint.offset + joint.factor * driver;
      let motion = IDENTITY;
      if (joint.turn) motion = rotationAbout(joint.turn, value);
      else if (joint.slide) motion = [...scale(joint.slide, value), 0, 0, 0, 1];
      poses[joint.child] = compose(compose(poses[joint.parent], joint.pose), motion);
    }
    return poses;
  }

  /** The tool frame of a robot whose links are at `poses`. */
  toolPose(robot, poses) {
    const [parent, pose] = this.scene.robots[robot].tool;
    return compose(poses[parent], pose);
  }

  /** The last event of an object, if any; it is held if that is an attach. */
  lastHandling(object, t) {
    return this.handling[object].findLast((event) => event.t <= t);
  }

  /** Everything that moves: links[robot][link], objects[object], and who holds each object (-1: nobody). */
  at(t) {
    const links = this.scene.robots.map((_, robot) => this.linkPoses(robot, t));
    const holders = [];
    const objects = this.scene.objects.map((object, i) => {
      const last = this.lastHandling(i, t);
      holders.push(last && last.attach ? last.robot : -1);
      if (!last) return object.pose;
      return last.attach ? compose(links[last.robot][last.link], last.link_from_object) : last.world_from_object;
    });
    return { links, objects, holders };
  }

  /** Where an object is put next after `t`; undefined if nowhere. */
  nextPlace(object, t) {
    const next = this.handling[object].find((event) => event.t > t && !event.attach);
    return next && next.world_from_object;
  }

  /** Index of a robot's segment at `t`; -1 before the first and after the last knot. */
  segmentAt(robot, t) {
    const { t: times, segments } = this.plan.robots[robot];
    return segments.findIndex((segment) => times[segment.from] <= t && t < times[segment.to]);
  }

  /** Points that should be in the picture: fixed objects, regions, objects, and robots wherever they go. */
  extent() {
    const points = [];
    for (const owner of [...this.scene.fixed, ...this.scene.objects]) {
      for (const body of owner.bodies) {
        const pose = compose(owner.pose, body.pose);
        points.push(...cornersOf(body).map((corner) => placed(pose, corner)));
      }
    }
    for (const region of this.scene.regions) points.push(region.pose.slice(0, 3));
    const steps = this.plan ? 40 : 0;
    for (let step = 0; step <= steps; step++) {
      const t = steps ? (this.duration * step) / steps : 0;
      this.scene.robots.forEach((_, robot) => points.push(...this.linkPoses(robot, t).map((pose) => pose.slice(0, 3))));
    }
    return points;
  }
}
