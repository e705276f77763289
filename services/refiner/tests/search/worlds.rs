//! Enumerated worlds in which everything that can fail fails for exact reasons. A simulation that knows neither orderings
//! nor causes says of each candidate whether some turns of the robots complete it: the search, with all causes, must end
//! at the first candidate that it can complete.

use std::rc::Rc;

use contract::{
    Alternative, Answer, Choice, Digest, DiscoveredOrder, FailureReport, JobId, Literal, ModeJob, Outcome, Placed,
    PlacementCandidate, PlacementJob, ProblemStatement, ProductRef, Request, Soundness,
};
use model::{PairId, Point, Pose, Problem};
use plan::{Cause, PairEnd};
use skeleton::{ArcOrigin, Event, EventGraph, ModeId, ModeKind, Occupancy, Skeleton};

use crate::scripted::{Rule, alternative, fails, no_path, statement};

/// Samples of each hop.
pub const SAMPLES: u32 = 2;
/// Most alternatives of a pair.
const ALTERNATIVES: u32 = 3;
/// `x` (m) of the poses of samples begins here, far from every start.
const FAR: f64 = 1000.0;

/// An alternative as configurations tell it: the grasp, and the samples at the two ends of the pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Way {
    pub pair: usize,
    pub index: u32,
    pub samples: [u32; 2],
}

/// A pose and the sample that it is.
pub type Stand = (Occupancy, u32);

/// One candidate of placement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Choices {
    pub samples: Vec<u32>,
    pub orders: Vec<(Event, Event)>,
}

/// How often things fail, in percent.
#[derive(Clone, Copy)]
pub struct Rates {
    pub roadmap: u64,
    pub reach: u64,
    pub grasp: u64,
    pub transition: u64,
    pub overlap: u64,
    /// Most alternatives of a pair.
    pub alternatives: u64,
}

pub struct World {
    pub statement: ProblemStatement,
    pub skeleton: Skeleton,
    pub candidates: Vec<Choices>,
    seed: u64,
    rates: Rates,
}

/// SplitMix64 over some numbers.
fn mix(numbers: &[u64]) -> u64 {
    numbers.iter().fold(0, |state: u64, number| {
        let mut z = (state ^ number).wrapping_add(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    })
}

fn of_stand((occupancy, sample): Stand) -> u64 {
    u64::from(occupancy.object.0) << 32 | u64::from(occupancy.hop) << 16 | u64::from(sample)
}

fn of_way(way: Option<Way>) -> u64 {
    way.map_or(0, |way| mix(&[way.pair as u64, way.index.into(), way.samples[0].into(), way.samples[1].into()]))
}

/// A configuration that tells an alternative and the end of it.
fn encode(way: Way, end: usize) -> f64 {
    let number = ((way.pair as u32 * 8 + way.index) * 8 + way.samples[0]) * 8 + way.samples[1];
    FAR + f64::from(number * 2 + end as u32)
}

pub fn decode(x: f64) -> Option<(Way, usize)> {
    let code = (x >= FAR).then_some((x - FAR) as u32)?;
    let (number, end) = (code / 2, code % 2);
    let samples = [number / 8 % 8, number % 8];
    Some((Way { pair: (number / 512) as usize, index: number / 64 % 8, samples }, end as usize))
}

fn pose_of(hop: u32, sample: u32) -> Pose {
    Pose::translation(FAR + f64::from(hop * 10 + sample), 0.0, 0.0)
}

/// Hop and sample that a pose is.
pub fn told_by(pose: &Pose) -> (u32, u32) {
    let x = pose.translation.x;
    let code = if x >= FAR { (x - FAR) as u32 } else { 0 };
    (code / 10, code % 10)
}

/// Three arms with a pair each, or two with two.
fn some_of_four_arms(problem: &mut Problem, seed: u64) {
    let (robots, pairs) = if seed.is_multiple_of(3) { (2, 2) } else { (3, 1) };
    let mut kept = vec![0; problem.robots.len()];
    problem.pairs.retain(|pair| {
        kept[pair.robot.index()] += 1;
        pair.robot.index() < robots && kept[pair.robot.index()] <= pairs
    });
}

impl World {
    pub fn new(scene: &str, seed: u64, rates: Rates) -> Rc<Self> {
        let mut statement = statement(scene);
        statement.problem.levels.highest = 0;
        statement.options.candidates = u32::MAX;
        if seed % 2 == 1 {
            statement.problem.orderings.clear();
        }
        if scene == "t24_four_arms" {
            some_of_four_arms(&mut statement.problem, seed);
        }
        let skeleton = Skeleton::of_problem(&statement.problem).unwrap();
        let mut world = Self { statement, skeleton, candidates: Vec::new(), seed, rates };
        let pairs = world.problem().pairs.len() as u32;
        for number in 0..SAMPLES.pow(pairs) {
            let samples: Vec<u32> = (0..pairs).map(|pair| number / SAMPLES.pow(pair) % SAMPLES).collect();
            let orders = world.orders_of(&samples);
            world.candidates.extend(orders.into_iter().map(|orders| Choices { samples: samples.clone(), orders }));
        }
        Rc::new(world)
    }

    pub fn problem(&self) -> &Problem {
        &self.statement.problem
    }

    fn is_bad(&self, percent: u64, numbers: &[u64]) -> bool {
        mix(&[self.seed, mix(numbers)]) % 100 < percent
    }

    /// The sample of each pose under a candidate; 0 at a start.
    pub fn sample(&self, samples: &[u32], occupancy: Occupancy) -> u32 {
        let hop = (occupancy.hop as usize).checked_sub(1);
        hop.map_or(0, |hop| samples[self.skeleton.hops[occupancy.object.index()][hop].index()])
    }

    /// The ways to order what overlaps: for each two poses that do, one is gone before the other comes.
    fn orders_of(&self, samples: &[u32]) -> Vec<Vec<(Event, Event)>> {
        let poses: Vec<Occupancy> = self.skeleton.occupancies().collect();
        let mut all = vec![(EventGraph::of_problem(self.problem()).unwrap(), Vec::new())];
        for (i, p) in poses.iter().enumerate() {
            for q in poses[..i].iter().filter(|q| q.object != p.object && p.hop + q.hop > 0) {
                let stands = [p, q].map(|pose| of_stand((*pose, self.sample(samples, *pose))));
                let moves = [p, q].iter().all(|pose| self.moves(pose.object));
                if !moves || !self.is_bad(self.rates.overlap, &[1, stands[0], stands[1]]) {
                    continue;
                }
                let [p, q] = [p, q].map(|pose| self.skeleton.interval_of(*pose));
                let either = [p.to.zip(q.from), q.to.zip(p.from)];
                let mut ordered = Vec::new();
                for (graph, orders) in all {
                    if either.iter().flatten().any(|(before, after)| graph.precedes_or_is(*before, *after)) {
                        ordered.push((graph, orders));
                        continue;
                    }
                    for (before, after) in either.iter().flatten() {
                        let mut graph = graph.clone();
                        if graph.add(*before, *after, ArcOrigin::Discovered).is_ok() {
                            ordered.push((graph, [orders.clone(), vec![(*before, *after)]].concat()));
                        }
                    }
                }
                all = ordered;
            }
        }
        all.into_iter().map(|(_, orders)| orders).collect()
    }

    /// Whether somebody moves an object; what nobody moves is in nobody's way.
    fn moves(&self, object: model::ObjectId) -> bool {
        !self.skeleton.hops[object.index()].is_empty()
    }

    /// How many alternatives a pair has.
    pub fn alternatives(&self, pair: usize, [from, to]: [u32; 2]) -> u32 {
        let (own, [from, to]) = (pair as u64, [from, to].map(u64::from));
        let rate = self.rates.transition;
        let is_impossible = self.is_bad(rate, &[2, own, from])
            || self.is_bad(rate, &[3, own, to])
            || self.is_bad(rate, &[4, own, from, to]);
        if is_impossible { 0 } else { 1 + (mix(&[self.seed, 5, own, from, to]) % self.rates.alternatives) as u32 }
    }

    /// Samples at the two ends of a pair.
    fn samples_at(&self, pair: usize) -> [u32; 2] {
        [if self.problem().pairs[pair].hop == 1 { 1 } else { SAMPLES }, SAMPLES]
    }

    fn leaves_no_grasp(&self, pair: usize, end: usize, own: u32, stand: Stand) -> bool {
        let is_other = stand.0.object != self.problem().pairs[pair].object && self.moves(stand.0.object);
        is_other && self.is_bad(self.rates.grasp, &[6, pair as u64, end as u64, own.into(), of_stand(stand)])
    }

    fn blocks_reach(&self, way: Way, end: usize, stand: Stand) -> bool {
        let own = way.samples[end];
        let numbers = [7, way.pair as u64, end as u64, way.index.into(), own.into(), of_stand(stand)];
        let is_other = stand.0.object != self.problem().pairs[way.pair].object && self.moves(stand.0.object);
        self.leaves_no_grasp(way.pair, end, own, stand) || is_other && self.is_bad(self.rates.reach, &numbers)
    }

    /// Whether an object is in one of the ways of a mode. What matters of the ends of the mode differs from pose to pose.
    fn is_in_way(&self, mode: ModeId, number: u64, ends: [Option<Way>; 2], stand: Stand) -> bool {
        let Some(own) = ends[1] else { return false };
        if stand.0.object == self.problem().pairs[own.pair].object || !self.moves(stand.0.object) {
            return false;
        }
        let end = usize::from(mode.step % 2 == 1);
        let (robot, step) = (u64::from(mode.robot.0), u64::from(mode.step));
        let what_matters = mix(&[self.seed, 8, robot, step, number, of_stand((stand.0, 0))]) % 4;
        let [start, goal] = [1, 2].map(|bit| what_matters & bit != 0);
        let ends = [of_way(ends[0].filter(|_| start)), of_way(ends[1].filter(|_| goal))];
        self.blocks_reach(own, end, stand)
            || self.is_bad(self.rates.roadmap, &[9, robot, step, number, ends[0], ends[1], of_stand(stand)])
    }

    fn ways(&self, mode: ModeId) -> std::ops::Range<u64> {
        0..1 + mix(&[self.seed, 10, mode.robot.0.into(), mode.step.into()]) % 2
    }

    /// Whether what stands about leaves a mode no way.
    pub fn is_closed(&self, mode: ModeId, ends: [Option<Way>; 2], about: &[Stand]) -> bool {
        self.ways(mode).all(|number| about.iter().any(|stand| self.is_in_way(mode, number, ends, *stand)))
    }

    /// All that may be chosen at an end of a mode.
    fn every_way(&self, pair: usize) -> Vec<Option<Way>> {
        let [from, to] = self.samples_at(pair);
        let of = |i: u32| Way { pair, index: i % 8, samples: [i / 8 % from, i / 8 / from] };
        (0..8 * from * to).filter(|i| i % 8 < ALTERNATIVES).map(|i| Some(of(i))).collect()
    }
}

/// The answers of the stages.
impl World {
    pub fn rules(self: &Rc<Self>) -> Vec<Rule> {
        let world = self.clone();
        vec![Box::new(move |request| world.answer(request))]
    }

    fn answer(&self, request: &Request) -> Option<Outcome> {
        let blocked = |blocked: Vec<bool>| Some(Outcome::answer(Answer::Blocked(blocked), 1));
        let stand = |standing: &model::Standing| {
            let (hop, sample) = told_by(&standing.world_from_object);
            (Occupancy { object: standing.object, hop }, sample)
        };
        match request {
            Request::Placement(job) => Some(self.place(job)),
            Request::Samples(job) => {
                let hop = self.problem().pair(job.pair).hop;
                let samples = (0..SAMPLES).map(|sample| (sample, pose_of(hop, sample))).collect();
                Some(Outcome::answer(Answer::Samples(samples), 1))
            }
            Request::Transition(job) => {
                let samples = [told_by(&job.world_from_pick).1, told_by(&job.world_from_place).1];
                Some(self.transition(job.pair, samples))
            }
            Request::Blockers(job) => {
                let (way, end) = decode(job.reach.at_object[0])?;
                blocked(job.standing.iter().map(|other| self.blocks_reach(way, end, stand(other))).collect())
            }
            Request::GraspBlockers(job) => {
                let (own, end) = (told_by(&job.world_from_object).1, usize::from(job.end == PairEnd::Place));
                let closes = |other| self.leaves_no_grasp(job.pair.index(), end, own, stand(other));
                blocked(job.standing.iter().map(closes).collect())
            }
            Request::Mode(job) => Some(self.roadmap(job)),
            _ => None,
        }
    }

    fn excludes(&self, nogood: &[Literal], candidate: &Choices) -> bool {
        nogood.iter().all(|literal| match literal {
            Literal::Pose { occupancy, sample } => self.sample(&candidate.samples, *occupancy) == *sample,
            Literal::Order { before, after } => candidate.orders.contains(&(*before, *after)),
            Literal::Alternative { .. } => false,
        })
    }

    /// The candidate that the placement stage gives out.
    pub fn next_candidate(&self, job: &PlacementJob) -> Option<&Choices> {
        let is_left = |candidate: &&Choices| !job.nogoods.iter().any(|nogood| self.excludes(nogood, candidate));
        self.candidates.iter().filter(is_left).nth(job.first as usize)
    }

    fn place(&self, job: &PlacementJob) -> Outcome {
        let Some(candidate) = self.next_candidate(job) else {
            let cause = Cause::NoPlacement { object: "o".into(), region: "w".into() };
            return fails(cause, Soundness::Soft { level: 0 });
        };
        let placed = |(pair, sample): (usize, &u32)| {
            let world_from_object = pose_of(self.problem().pairs[pair].hop, *sample);
            Placed { pair: PairId::at(pair), sample: *sample, world_from_object }
        };
        let placements = candidate.samples.iter().enumerate().map(placed).collect();
        let order = |(before, after): &(Event, Event)| DiscoveredOrder {
            before: *before,
            after: *after,
            cause: no_path("overlap"),
        };
        let orders = candidate.orders.iter().map(order).collect();
        Outcome::answer(Answer::Placements(vec![PlacementCandidate { index: job.first, placements, orders }]), 1)
    }

    fn transition(&self, pair: PairId, samples: [u32; 2]) -> Outcome {
        let most = self.alternatives(pair.index(), samples);
        if most == 0 {
            let is_none = |from, to| self.alternatives(pair.index(), [from, to]) == 0;
            let [from, to] = self.samples_at(pair.index());
            let (picked, placed) =
                (self.skeleton.picked(self.problem(), pair), self.skeleton.placed(self.problem(), pair));
            let rests_on = if (0..to).all(|to| is_none(samples[0], to)) {
                vec![picked]
            } else if (0..from).all(|from| is_none(from, samples[1])) {
                vec![placed]
            } else {
                vec![picked, placed]
            };
            return fails_for(rests_on.into_iter().map(Choice::Pose).collect());
        }
        let offered = |index: u32| {
            let way = Way { pair: pair.index(), index, samples };
            let mut told: Alternative = alternative(self.problem(), pair, index);
            for (end, reach) in [&mut told.pick, &mut told.place].into_iter().enumerate() {
                reach.at_object[0] = encode(way, end);
            }
            told
        };
        Outcome::answer(Answer::Alternatives((0..most).map(offered).collect()), 1)
    }

    fn roadmap(&self, job: &ModeJob) -> Outcome {
        let mode = self.skeleton.mode(job.mode);
        let stands = |obstructions: &[contract::Obstruction]| -> Vec<Stand> {
            obstructions.iter().map(|o| (o.occupancy, told_by(&o.standing.world_from_object).1)).collect()
        };
        let (certain, possible) = (stands(&job.certain), stands(&job.possible));
        let way_of = |q: &[f64]| decode(q[0]).map(|(way, _)| way);
        let goal = if mode.kind == ModeKind::Return { None } else { way_of(&job.goal) };
        let ends = [way_of(&job.start), goal];
        if mode.kind != ModeKind::Return && self.is_closed(job.mode, ends, &certain) {
            return fails_for(self.least_reason(job.mode, ends, certain));
        }
        let is_free = |number: &u64| !certain.iter().any(|stand| self.is_in_way(job.mode, *number, ends, *stand));
        let obstacles = |number: u64| -> Vec<u32> {
            let indexed = (0_u32..).zip(&possible);
            indexed.filter(|(_, stand)| self.is_in_way(job.mode, number, ends, **stand)).map(|(i, _)| i).collect()
        };
        let in_the_way = self.ways(job.mode).filter(is_free).map(obstacles).min_by_key(Vec::len).unwrap_or_default();
        let digest = Digest::of("test", &[&contract::encode_canonical(job)]);
        let roadmap = ProductRef { digest, made_by: JobId(digest) };
        Outcome::answer(Answer::Mode { roadmap, shortest_s: 1.0, in_the_way }, 1)
    }

    /// Poses and alternatives that close a mode whatever else is chosen, and none of which can be spared.
    fn least_reason(&self, mode: ModeId, ends: [Option<Way>; 2], mut poses: Vec<Stand>) -> Vec<Choice> {
        let mut needed = ends;
        let closes = |ends: [Option<Way>; 2], poses: &[Stand]| {
            let every = |end: usize| match (ends[end], mode.step % 2, end) {
                (Some(way), ..) => vec![Some(way)],
                (None, 1, 0) => vec![None],
                (None, ..) => self.pair_at(mode, end).map_or(vec![None], |pair| self.every_way(pair)),
            };
            every(1).into_iter().all(|goal| {
                let starts = if mode.step % 2 == 1 { vec![goal] } else { every(0) };
                starts.into_iter().all(|start| self.is_closed(mode, [start, goal], poses))
            })
        };
        if mode.step % 2 == 1 {
            needed[0] = None;
        }
        let poses_first = mix(&[self.seed, 11, mode.step.into()]).is_multiple_of(2);
        for spare_poses in [poses_first, !poses_first] {
            if spare_poses {
                for stand in poses.clone() {
                    let fewer: Vec<Stand> = poses.iter().filter(|other| **other != stand).copied().collect();
                    if closes(needed, &fewer) {
                        poses = fewer;
                    }
                }
            } else {
                for end in 0..2 {
                    let mut fewer = needed;
                    fewer[end] = None;
                    if closes(fewer, &poses) {
                        needed = fewer;
                    }
                }
            }
        }
        let pairs = needed.into_iter().flatten().map(|way| Choice::Alternative(PairId::at(way.pair)));
        pairs.chain(poses.into_iter().map(|(occupancy, _)| Choice::Pose(occupancy))).collect()
    }

    /// The pair at an end of a mode.
    fn pair_at(&self, mode: ModeId, end: usize) -> Option<usize> {
        let mode = self.skeleton.mode(mode);
        let pair = if end == 0 { mode.begins.map(|event| event.pair) } else { mode.pair };
        pair.map(PairId::index)
    }
}

pub fn fails_for(rests_on: Vec<Choice>) -> Outcome {
    let report = FailureReport {
        causes: vec![(no_path("x"), 1)],
        soundness: Soundness::Soft { level: 0 },
        certificate: None,
        rests_on: Some(rests_on),
    };
    Outcome { result: Err(report), work: 1 }
}

/// The oracle: robots take turns, a mode at a time. A mode can be done where what stands about at its end leaves it a way.
impl World {
    pub fn can_be_completed(&self, candidate: &Choices) -> bool {
        let numbers: Vec<u32> = (0..self.problem().pairs.len())
            .map(|pair| self.alternatives(pair, self.ends_of(pair, candidate)))
            .collect();
        let combinations: u32 = numbers.iter().product();
        (0..combinations).any(|mut number| {
            let mut ways = Vec::new();
            for (pair, count) in numbers.iter().enumerate() {
                ways.push(Way { pair, index: number % count, samples: self.ends_of(pair, candidate) });
                number /= count;
            }
            self.turns_exist(candidate, &ways)
        })
    }

    fn ends_of(&self, pair: usize, candidate: &Choices) -> [u32; 2] {
        let id = PairId::at(pair);
        [self.skeleton.picked(self.problem(), id), self.skeleton.placed(self.problem(), id)]
            .map(|pose| self.sample(&candidate.samples, pose))
    }

    fn turns_exist(&self, candidate: &Choices, ways: &[Way]) -> bool {
        let robots = self.problem().robots.len();
        let modes_of = |robot: usize| self.problem().pairs_of_robot(model::RobotId::at(robot)).count() * 2;
        let mut seen = std::collections::BTreeSet::from([vec![0; robots]]);
        let mut open = vec![vec![0; robots]];
        while let Some(done) = open.pop() {
            if (0..robots).all(|robot| done[robot] == modes_of(robot)) {
                return true;
            }
            for robot in (0..robots).filter(|robot| done[*robot] < modes_of(*robot)) {
                if self.can_be_next(candidate, ways, &done, robot) {
                    let mut next = done.clone();
                    next[robot] += 1;
                    if seen.insert(next.clone()) {
                        open.push(next);
                    }
                }
            }
        }
        false
    }

    fn has_happened(&self, done: &[usize], event: Event) -> bool {
        let robot = self.problem().pair(event.pair).robot;
        let place = self.problem().pairs_of_robot(robot).position(|pair| pair == event.pair).unwrap();
        let modes = match event.point {
            Point::Grasp => 2 * place + 1,
            Point::Release => 2 * place + 2,
            other => panic!("no ordering of these worlds is on {other:?}"),
        };
        done[robot.index()] >= modes
    }

    fn can_be_next(&self, candidate: &Choices, ways: &[Way], done: &[usize], robot: usize) -> bool {
        let id = ModeId { robot: model::RobotId::at(robot), step: done[robot] as u32 };
        let pairs: Vec<PairId> = self.problem().pairs_of_robot(id.robot).collect();
        let pair = pairs[done[robot] / 2];
        let event = if done[robot].is_multiple_of(2) { Event::grasp(pair) } else { Event::release(pair) };
        let given = self.problem().orderings.iter();
        let given = given.map(|g| (Event::new(g.before.0, g.before.1), Event::new(g.after.0, g.after.1)));
        let mut orders = given.chain(candidate.orders.iter().copied());
        if orders.any(|(before, after)| after == event && !self.has_happened(done, before)) {
            return false;
        }
        let own = self.problem().pair(pair);
        let hops = &self.skeleton.hops[own.object.index()];
        let previous = (own.hop as usize).checked_sub(2).map(|hop| hops[hop]);
        if previous.is_some_and(|previous| !self.has_happened(done, Event::release(previous))) {
            return false;
        }
        let is_there = |pose: &Occupancy| {
            let stay = self.skeleton.interval_of(*pose);
            stay.from.is_none_or(|event| self.has_happened(done, event))
                && !stay.to.is_some_and(|event| self.has_happened(done, event))
        };
        let about = self.skeleton.occupancies().filter(is_there);
        let about: Vec<Stand> = about.map(|pose| (pose, self.sample(&candidate.samples, pose))).collect();
        let start = match done[robot] % 2 {
            0 => (done[robot] / 2).checked_sub(1).map(|before| ways[pairs[before].index()]),
            _ => Some(ways[pair.index()]),
        };
        !self.is_closed(id, [start, Some(ways[pair.index()])], &about)
    }
}
