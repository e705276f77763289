//! Rules V11 and V12: no two bodies meet at any instant, but for allowed contacts.

use plan::BodyRef;

use crate::actor::Actor;
use crate::script::Script;
use crate::solid::Solid;
use crate::surroundings::{Surroundings, What};
use crate::sweep::{Candidate, Encounter, Hit, Placed, Sweep};
use crate::timeline::Timeline;
use crate::violation::{LeastClearance, Rule, Verdict, Violation};

/// Checks all pairs: robot and robot, robot and what stands, robot and itself, standing objects and what stands.
pub(crate) fn check(script: &Script, timeline: &Timeline, verdict: &mut Verdict, wrong: &mut Vec<Violation>) {
    let surroundings = Surroundings::new(script, timeline);
    check_standing(script, timeline, &surroundings, wrong);
    let mut actors: Vec<Actor> = (0..script.tracks.len()).map(|robot| Actor::new(script, timeline, robot)).collect();
    for i in 0..actors.len() {
        let (before, rest) = actors.split_at_mut(i);
        check_itself(&mut rest[0], script.horizon(), verdict, wrong);
        check_around(script, timeline, &surroundings, &mut rest[0], verdict, wrong);
        for other in before {
            check_between(other, &mut rest[0], script.horizon(), verdict, wrong);
        }
    }
}

/// Two robots.
struct Between<'b, 'a>(&'b mut Actor<'a>, &'b mut Actor<'a>);

impl Encounter for Between<'_, '_> {
    fn place(&mut self, t: f64) {
        self.0.place(t);
        self.1.place(t);
    }
    fn first(&self, candidate: &Candidate) -> (&Solid, &Placed) {
        self.0.body(candidate.first)
    }
    fn second(&self, candidate: &Candidate) -> (&Solid, &Placed) {
        self.1.body(candidate.second)
    }
}

/// A robot and itself.
struct Within<'b, 'a>(&'b mut Actor<'a>);

impl Encounter for Within<'_, '_> {
    fn place(&mut self, t: f64) {
        self.0.place(t);
    }
    fn first(&self, candidate: &Candidate) -> (&Solid, &Placed) {
        self.0.body(candidate.first)
    }
    fn second(&self, candidate: &Candidate) -> (&Solid, &Placed) {
        self.0.body(candidate.second)
    }
    fn closing_speed(&self, candidate: &Candidate) -> f64 {
        self.0.own_speed(candidate.first, candidate.second)
    }
}

/// A robot and what stands.
struct Around<'b, 'a>(&'b mut Actor<'a>, &'b Surroundings);

impl Encounter for Around<'_, '_> {
    fn place(&mut self, t: f64) {
        self.0.place(t);
    }
    fn first(&self, candidate: &Candidate) -> (&Solid, &Placed) {
        self.0.body(candidate.first)
    }
    fn second(&self, candidate: &Candidate) -> (&Solid, &Placed) {
        let still = &self.1.bodies[candidate.second];
        (&still.solid, &still.placed)
    }
}

/// Stretches of time between consecutive breaks, from 0 to `horizon`.
fn stretches(breaks: impl Iterator<Item = f64>, horizon: f64) -> Vec<(f64, f64)> {
    let mut times: Vec<f64> = breaks.filter(|t| *t > 0.0 && *t < horizon).chain([0.0, horizon]).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    if times.len() == 1 { vec![(0.0, 0.0)] } else { times.windows(2).map(|pair| (pair[0], pair[1])).collect() }
}

fn check_between<'a>(
    a: &mut Actor<'a>,
    b: &mut Actor<'a>,
    horizon: f64,
    verdict: &mut Verdict,
    wrong: &mut Vec<Violation>,
) {
    let columns = b.link_bodies() + 1;
    let mut sweep = Sweep::new((a.link_bodies() + 1) * columns);
    for stretch in stretches(a.track.times().chain(b.track.times()), horizon) {
        let ((near, near_radius), (far, far_radius)) = (a.room(stretch.0), b.room(stretch.0));
        if near.distance(far) > near_radius + far_radius {
            sweep.tally.intervals += 1;
            continue;
        }
        if a.enter(stretch) {
            let row = a.link_bodies() * columns;
            sweep.renew(row..row + columns);
        }
        if b.enter(stretch) {
            sweep.renew((0..=a.link_bodies()).map(|i| i * columns + columns - 1));
        }
        let (rows, width) = (a.bodies(), b.bodies());
        let candidates = (0..rows).flat_map(|first| {
            (0..width).map(move |second| Candidate { first, second, slot: first * columns + second, lift: 0.0 })
        });
        sweep.examine(&mut Between(a, b), stretch, candidates);
    }
    finish(&sweep, verdict, |_, least| &mut least.robot_robot);
    for hit in &sweep.hits {
        let (first, second) = (a.name(hit.candidate.first, hit.t), b.name(hit.candidate.second, hit.t));
        wrong.push(met(Rule::V11, &first, &second, hit));
    }
}

fn check_itself(actor: &mut Actor, horizon: f64, verdict: &mut Verdict, wrong: &mut Vec<Violation>) {
    let columns = actor.link_bodies() + 1;
    let mut sweep = Sweep::new(columns * columns);
    let slot = |first: usize, second: usize| first * columns + second;
    let own = own_pairs(actor);
    let robot = actor.robot;
    let load = columns - 1;
    let untouchable: Vec<usize> = (0..load).filter(|i| !robot.is_touch_link(actor.link(*i))).collect();
    for stretch in stretches(actor.track.times(), horizon) {
        if actor.enter(stretch) {
            sweep.renew((0..columns).map(|i| slot(i, load)));
        }
        let with_load = if actor.hold().is_some() { untouchable.as_slice() } else { &[] };
        let pairs = own.iter().copied().chain(with_load.iter().map(|i| (*i, load)));
        let candidates = pairs.map(|(first, second)| Candidate { first, second, slot: slot(first, second), lift: 0.0 });
        sweep.examine(&mut Within(actor), stretch, candidates);
    }
    finish(&sweep, verdict, |_, least| &mut least.own);
    for hit in &sweep.hits {
        let (first, second) = (actor.name(hit.candidate.first, hit.t), actor.name(hit.candidate.second, hit.t));
        wrong.push(met(Rule::V11, &first, &second, hit));
    }
}

/// Pairs of a robot's own bodies that could meet: not disabled, and able to move against one another.
fn own_pairs(actor: &Actor) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    for second in 0..actor.link_bodies() {
        for first in 0..second {
            let (a, b) = (actor.link(first).min(actor.link(second)), actor.link(first).max(actor.link(second)));
            if a != b && !actor.robot.disabled_pairs.contains(&(a, b)) && actor.mechanism.can_move(a, b) {
                pairs.push((first, second));
            }
        }
    }
    pairs
}

fn check_around(
    script: &Script,
    timeline: &Timeline,
    surroundings: &Surroundings,
    actor: &mut Actor,
    verdict: &mut Verdict,
    wrong: &mut Vec<Violation>,
) {
    let (columns, load) = (surroundings.bodies.len(), actor.link_bodies());
    let own: Vec<usize> = (0..timeline.holds.len())
        .filter(|i| script.problem.robot(timeline.holds[*i].robot).name == actor.robot.name)
        .collect();
    let touching: Vec<bool> = (0..load).map(|i| actor.robot.is_touch_link(actor.link(i))).collect();
    let mut sweep = Sweep::new((load + 1) * columns);
    let presence = surroundings.bodies.iter().flat_map(|still| [still.from, still.to]);
    let windows = own.iter().flat_map(|hold| surroundings.windows[*hold].breaks());
    for stretch in stretches(actor.track.times().chain(presence).chain(windows), script.horizon()) {
        let middle = f64::midpoint(stretch.0, stretch.1);
        if actor.enter(stretch) {
            sweep.renew(load * columns..(load + 1) * columns);
        }
        let (hold, ball, half) = (actor.hold(), actor.ball(), (stretch.1 - stretch.0) / 2.0);
        let bodies = actor.bodies();
        let near = (0..columns).filter(|k| {
            let still = &surroundings.bodies[*k];
            // Somewhat more than the sum, for what an allowed contact may overlap.
            let reach = 1.01 * ball.radius + still.solid.radius + ball.speed * half + 1e-2;
            still.from <= stretch.0 && stretch.1 <= still.to && still.placed.centre.distance(ball.centre) <= reach
        });
        let candidate = |first: usize, second: usize| {
            let touches = |hold: &usize| surroundings.hand_may_touch(*hold, second, middle);
            if touching.get(first).is_some_and(|touching| *touching) && own.iter().any(touches) {
                return None;
            }
            let lift = hold.filter(|_| first == load).map_or(0.0, |hold| surroundings.lift(hold, second, middle));
            Some(Candidate { first, second, slot: first * columns + second, lift })
        };
        let candidates = near.flat_map(|k| (0..bodies).filter_map(move |i| candidate(i, k)));
        sweep.examine(&mut Around(actor, surroundings), stretch, candidates);
    }
    finish(&sweep, verdict, |slot, least| match surroundings.bodies[slot % columns].what {
        What::Fixed(_) => &mut least.robot_fixed,
        What::Standing(_) => &mut least.robot_object,
    });
    for hit in &sweep.hits {
        let Candidate { first, second, .. } = hit.candidate;
        let is_hand = touching.get(first).is_some_and(|touching| *touching);
        let out_of_window =
            |hold: &usize| (is_hand || first == load) && surroundings.concerns(*hold, second, first == load);
        let rule = if own.iter().any(out_of_window) { Rule::V12 } else { Rule::V11 };
        wrong.push(met(rule, &actor.name(first, hit.t), &surroundings.name(script, timeline, second), hit));
    }
}

/// Standing objects keep apart from one another and from fixed objects, but for what they rest on.
fn check_standing(script: &Script, timeline: &Timeline, surroundings: &Surroundings, wrong: &mut Vec<Violation>) {
    let bodies = &surroundings.bodies;
    for (j, object) in bodies.iter().enumerate() {
        let What::Standing(standing) = object.what else { continue };
        for (i, other) in bodies[..j].iter().enumerate() {
            let (from, to) = (object.from.max(other.from), object.to.min(other.to));
            if from >= to {
                continue;
            }
            let mut frame = object.placed.frame;
            if surroundings.rests_on(standing, i) {
                // The height is V7's business; here it must only not sink deeper than that allows.
                frame.origin.z += script.problem.settings.support_tolerance + 1e-6;
            }
            if object.solid.certified_gap(&frame, &other.solid, &other.placed.frame) <= 0.0 {
                let depth = object.solid.depth(&frame, &other.solid, &other.placed.frame);
                let candidate = Candidate { first: j, second: i, slot: 0, lift: 0.0 };
                let name = |k: usize| surroundings.name(script, timeline, k);
                wrong.push(met(Rule::V11, &name(j), &name(i), &Hit { candidate, t: from.max(0.0), depth }));
            }
        }
    }
}

/// Adds a search's work and least distances to the verdict; `kind` says where a pair's distance belongs.
fn finish(sweep: &Sweep, verdict: &mut Verdict, kind: impl Fn(usize, &mut LeastClearance) -> &mut Option<f64>) {
    verdict.intervals += sweep.tally.intervals;
    verdict.pairs_tested += sweep.tally.pairs;
    verdict.distances += sweep.tally.distances;
    verdict.floor_hits += sweep.hits.iter().filter(|hit| hit.depth <= 0.0).count() as u64;
    for (slot, distance) in sweep.least.iter().enumerate().filter(|(_, distance)| distance.is_finite()) {
        let least = kind(slot, &mut verdict.least_clearance);
        *least = Some(least.map_or(*distance, |known| known.min(*distance)));
    }
}

fn met(rule: Rule, first: &BodyRef, second: &BodyRef, hit: &Hit) -> Violation {
    let how = match hit.depth {
        depth if depth > 0.0 => format!("overlap by about {:.3} mm", depth * 1e3),
        _ => "come closer than can be told from touching".to_owned(),
    };
    let mut violation = Violation::new(rule, format!("{first} and {second} {how}")).at(hit.t);
    for body in [first, second] {
        violation = match body {
            BodyRef::Link { robot, .. } => violation.robot(robot),
            BodyRef::Held { robot, object } => violation.robot(robot).object(object),
            BodyRef::Fixed(name) | BodyRef::Object(name) => violation.object(name),
        };
    }
    violation
}
