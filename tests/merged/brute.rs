//! All combinations of samples with all ways to order their collisions, each tested up to the transition stage: the sets
//! are made without the placement stage's search and without the refiner.

use std::collections::BTreeSet;

use collision::Geometry;
use contract::{Alternative, Answer, AskStages, BlockersJob, HopJob, Job, Outcome, Placed, Request, TransitionJob};
use model::{Holding, PairId, Problem, Standing};
use skeleton::{ArcOrigin, Event, EventGraph, Interval, Occupancy, Presence, Skeleton};

use crate::acceptance::{Pipelines, Placement};
use crate::orders::irredundant;

/// Alternatives that the search asks for.
const ALTERNATIVES: u32 = 48;

pub struct Brute<'a> {
    pipelines: &'a mut Pipelines,
    problem: Problem,
    skeleton: Skeleton,
    geometry: Geometry,
    /// Samples of each pair that touch nothing fixed.
    samples: Vec<Vec<Placed>>,
}

/// What the brute force found.
#[derive(Default)]
pub struct Found {
    /// Placements without collisions.
    pub placements: BTreeSet<Placement>,
    /// Those of them that have alternatives for every pair.
    pub with_alternatives: BTreeSet<Placement>,
}

impl<'a> Brute<'a> {
    pub fn new(pipelines: &'a mut Pipelines) -> Self {
        let problem = pipelines.problem().clone();
        let (skeleton, geometry) = (Skeleton::of_problem(&problem).unwrap(), Geometry::new(&problem).unwrap());
        let mut brute = Self { pipelines, samples: Vec::new(), skeleton, geometry, problem };
        brute.samples = (0..brute.problem.pairs.len()).map(|pair| brute.samples_of(PairId::at(pair))).collect();
        brute
    }

    fn ask(&mut self, request: Request, budget: u64) -> Outcome {
        self.pipelines.calls.ask(&[Job { request, budget }]).unwrap().remove(0)
    }

    fn samples_of(&mut self, pair: PairId) -> Vec<Placed> {
        let job = HopJob { pair, level: 0, placed: Vec::new(), orders: Vec::new(), first: 0, count: 10_000 };
        let Ok(Answer::Hop { choices, .. }) = self.ask(Request::Hop(job), 4_000_000).result else {
            panic!("no answer")
        };
        let mut samples: Vec<Placed> = choices.into_iter().map(|choice| choice.placed).collect();
        samples.sort_by_key(|placed| placed.sample);
        samples.dedup_by_key(|placed| placed.sample);
        samples
    }

    pub fn all(mut self) -> Found {
        let mut found = Found::default();
        self.choose(&mut Vec::new(), &mut found);
        found
    }

    fn choose(&mut self, placed: &mut Vec<Placed>, found: &mut Found) {
        let Some(samples) = self.samples.get(placed.len()).cloned() else { return self.order(placed, found) };
        for sample in samples {
            placed.push(sample);
            self.choose(placed, found);
            placed.pop();
        }
    }

    fn standing(&self, placed: &[Placed], occupancy: Occupancy) -> Standing {
        let world_from_object = match occupancy.hop.checked_sub(1) {
            None => self.problem.movable[occupancy.object.index()].world_from_start,
            Some(hop) => placed[self.skeleton.hops[occupancy.object.index()][hop as usize].index()].world_from_object,
        };
        Standing { object: occupancy.object, world_from_object }
    }

    /// Orders all collisions in all ways.
    fn order(&mut self, placed: &[Placed], found: &mut Found) {
        let all: Vec<Occupancy> = self.skeleton.occupancies().collect();
        let mut collisions = Vec::new();
        for (i, a) in all.iter().enumerate() {
            for b in &all[..i] {
                let [x, y] = [a, b].map(|occupancy| self.standing(placed, *occupancy));
                // What stands at the start stands as the problem says, also where two touch.
                let given = a.hop == 0 && b.hop == 0;
                if a.object != b.object && !given && self.geometry.standings_collide(&x, &y) {
                    collisions.push([self.skeleton.interval_of(*a), self.skeleton.interval_of(*b)]);
                }
            }
        }
        let mut sets = BTreeSet::new();
        self.orient(&collisions, &self.skeleton.graph.clone(), &mut Vec::new(), &mut sets);
        for orders in sets {
            let placement = (placed.iter().map(|placed| placed.sample).collect(), orders);
            if self.has_alternatives(placed, &placement.1) {
                found.with_alternatives.insert(placement.clone());
            }
            found.placements.insert(placement);
        }
    }

    fn orient(
        &self,
        collisions: &[[Interval; 2]],
        graph: &EventGraph,
        orders: &mut Vec<(Event, Event)>,
        sets: &mut BTreeSet<Vec<(Event, Event)>>,
    ) {
        let Some(([a, b], rest)) = collisions.split_first() else {
            sets.insert(irredundant(&self.problem, orders));
            return;
        };
        if !graph.may_overlap(*a, *b) {
            return self.orient(rest, graph, orders, sets);
        }
        for (before, after) in [(a.to, b.from), (b.to, a.from)] {
            let (Some(before), Some(after)) = (before, after) else { continue };
            let mut graph = graph.clone();
            if graph.add(before, after, ArcOrigin::Discovered).is_ok() {
                orders.push((before, after));
                self.orient(rest, &graph, orders, sets);
                orders.pop();
            }
        }
    }

    fn has_alternatives(&mut self, placed: &[Placed], orders: &[(Event, Event)]) -> bool {
        let mut graph = self.skeleton.graph.clone();
        orders.iter().for_each(|(before, after)| graph.add(*before, *after, ArcOrigin::Discovered).unwrap());
        (0..self.problem.pairs.len()).map(PairId::at).all(|pair| {
            let [from, to] = [self.skeleton.picked(&self.problem, pair), self.skeleton.placed(&self.problem, pair)];
            let request = Request::Transition(TransitionJob {
                pair,
                world_from_pick: self.standing(placed, from).world_from_object,
                world_from_place: self.standing(placed, to).world_from_object,
                level: 0,
                first: 0,
                count: ALTERNATIVES,
            });
            let Ok(Answer::Alternatives(alternatives)) = self.ask(request, 200_000).result else { return false };
            alternatives.iter().any(|alternative| self.is_free(placed, &graph, pair, alternative))
        })
    }

    /// Whether nothing that is certainly there blocks an alternative.
    fn is_free(&mut self, placed: &[Placed], graph: &EventGraph, pair: PairId, alternative: &Alternative) -> bool {
        let (robot, object) = (self.problem.pair(pair).robot, self.problem.pair(pair).object);
        [(Event::grasp(pair), &alternative.pick), (Event::release(pair), &alternative.place)].into_iter().all(
            |(event, reach)| {
                let instant = Interval { from: Some(event), to: Some(event) };
                let certain = |occupancy: &Occupancy| {
                    let interval = self.skeleton.interval_of(*occupancy);
                    occupancy.object != object && graph.presence(interval, instant) == Presence::Certain
                };
                let standing =
                    self.skeleton.occupancies().filter(certain).map(|o| self.standing(placed, o)).collect::<Vec<_>>();
                let holding = Holding { object, grasp: alternative.grasp };
                let request = Request::Blockers(BlockersJob { robot, holding, reach: reach.clone(), standing });
                let Ok(Answer::Blocked(blocked)) = self.ask(request, 10_000).result else { panic!("no answer") };
                !blocked.contains(&true)
            },
        )
    }
}
