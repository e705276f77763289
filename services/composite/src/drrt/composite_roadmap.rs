//! The implicit composite roadmap: the tensor product of the robots' glued mode roadmaps, never built.

use std::borrow::Cow;

use contract::{Interrupted, ModeRoadmap, VertexId};
use model::{Problem, RobotId};
use skeleton::{Event, ModeId, Occupancy, Skeleton};

use super::mode_graph::{Arc, ModeGraph, MotionNumbers};
use super::phase::{Phase, is_beginning, ordered_points, phases_of_mode};
use super::validity::TimedEdge;

/// Least time between ordered events (s), where the hand needs none: the order is strict.
const LEAST_REST_S: f64 = 1e-6;

/// One robot's modes and phases in order.
#[derive(Clone, Debug)]
pub(super) struct RobotRoadmap<'a> {
    pub modes: Vec<ModeGraph<'a>>,
    pub phases: Vec<Phase>,
}

impl RobotRoadmap<'_> {
    /// The roadmap of the closing return: the last mode, if no event ends it and it is not one made up here.
    pub fn closing(&self) -> Option<&ModeRoadmap> {
        let last = &self.modes.last()?.roadmap;
        let is_given = matches!(last, Cow::Borrowed(_));
        is_given.then_some(last.as_ref())
    }
}

/// A point in the progress of one robot: its phase number `phase` is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Passed {
    pub robot: usize,
    pub phase: u32,
}

/// An object's pose and when it is there; `None` stands for the start, or the end, of time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stay {
    pub occupancy: Occupancy,
    pub from: Option<Passed>,
    pub until: Option<Passed>,
}

/// All that stays the same during a search.
#[derive(Clone, Debug)]
pub(super) struct CompositeRoadmap<'a> {
    pub problem: &'a Problem,
    pub robots: Vec<RobotRoadmap<'a>>,
    /// Poses of objects, sorted by occupancy.
    pub stays: Vec<Stay>,
    /// The point at which the search ends; else when all robots have come to the ends of their last phases.
    pub aim: Option<Passed>,
}

/// One motion of one robot: travelling arc `arc` of vertex `from`, or standing there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Motion {
    pub robot: usize,
    pub mode: usize,
    pub from: VertexId,
    pub arc: Option<usize>,
}

impl<'a> CompositeRoadmap<'a> {
    /// Glues the roadmaps of every mode of every robot to one product.
    ///
    /// # Errors
    /// [`Interrupted::Unfit`]: the roadmaps are not those of the skeleton's modes.
    pub fn new(
        problem: &'a Problem,
        skeleton: &Skeleton,
        roadmaps: &'a [Vec<ModeRoadmap>],
    ) -> Result<Self, Interrupted> {
        let occupancies: Vec<Occupancy> = skeleton.occupancies().collect();
        let ordered = ordered_points(problem, &skeleton.graph);
        let mut robots: Vec<RobotRoadmap<'a>> = Vec::with_capacity(problem.robots.len());
        let mut numbers = MotionNumbers::default();
        for robot in problem.robot_ids() {
            let roadmaps = all_modes(problem, skeleton, robot, roadmaps)?;
            let mut glued = RobotRoadmap { modes: Vec::with_capacity(roadmaps.len()), phases: Vec::new() };
            for (step, roadmap) in roadmaps.into_iter().enumerate() {
                let graph = ModeGraph::new(roadmap, problem.robot(robot), &occupancies, &mut numbers)?;
                let rest_s = problem.settings.grip_time.max(LEAST_REST_S);
                let phases = match skeleton.modes[robot.index()].get(step) {
                    Some(mode) => phases_of_mode(problem, mode, &graph, &ordered, rest_s),
                    None => vec![final_stand(step, &graph)],
                };
                if let Some(last) = glued.phases.last_mut() {
                    last.enters = graph.roadmap.start;
                }
                glued.phases.extend(phases);
                glued.modes.push(graph);
            }
            robots.push(glued);
        }
        let mut composite = Self { problem, robots, stays: Vec::new(), aim: None };
        composite.stays = occupancies.iter().map(|occupancy| composite.stay(skeleton, *occupancy)).collect();
        composite.order_phases(skeleton);
        composite.measure_what_remains();
        Ok(composite)
    }

    fn stay(&self, skeleton: &Skeleton, occupancy: Occupancy) -> Stay {
        let interval = skeleton.interval_of(occupancy);
        let passed = |event: Option<Event>| event.and_then(|event| self.phase_of(event));
        Stay { occupancy, from: passed(interval.from), until: passed(interval.to) }
    }

    fn phase_of(&self, event: Event) -> Option<Passed> {
        let robot = self.problem.pair(event.pair).robot.index();
        let phase = self.robots[robot].phases.iter().position(|phase| phase.events.contains(&event))?;
        Some(Passed { robot, phase: phase as u32 })
    }

    /// Fills in what must be over before each phase's event.
    fn order_phases(&mut self, skeleton: &Skeleton) {
        let events: Vec<Vec<Vec<Event>>> =
            self.robots.iter().map(|robot| robot.phases.iter().map(|phase| phase.events.clone()).collect()).collect();
        let precedes = |before: &[Event], after: &[Event]| {
            before.iter().any(|b| after.iter().any(|a| skeleton.graph.precedes(*b, *a)))
        };
        let problem = self.problem;
        for (robot, glued) in self.robots.iter_mut().enumerate() {
            for phase in &mut glued.phases {
                if phase.events.iter().any(|event| is_beginning(problem, *event)) {
                    phase.needs = vec![u32::MAX; events.len()];
                    continue;
                }
                let over = |other: usize| {
                    let before = |p: &usize| precedes(&events[other][*p], &phase.events);
                    let last = (0..events[other].len()).rev().find(before).filter(|_| other != robot);
                    last.map_or(0, |p| p as u32 + 1)
                };
                phase.needs = (0..events.len()).map(over).collect();
            }
        }
    }

    /// Longest chain of least times from each phase's event to the end, over the robots' chains and the gates.
    fn measure_what_remains(&mut self) {
        let total: usize = self.robots.iter().map(|robot| robot.phases.len()).sum();
        for _ in 0..total {
            let mut changed = false;
            for r in 0..self.robots.len() {
                for p in (0..self.robots[r].phases.len()).rev() {
                    let remaining = self.remaining_after(r, p);
                    changed |= remaining > self.robots[r].phases[p].remaining_s;
                    self.robots[r].phases[p].remaining_s = remaining;
                }
            }
            if !changed {
                return;
            }
        }
    }

    fn remaining_after(&self, robot: usize, phase: usize) -> f64 {
        let phases = &self.robots[robot].phases;
        let own = phases.get(phase + 1).map_or(0.0, |next| {
            phases[phase].rest_s + next.cost_to_go_s[phases[phase].enters.index()] + next.remaining_s
        });
        let waiting = self.robots.iter().flat_map(|other| &other.phases);
        let waiting = waiting.filter(|other| other.needs.get(robot) == Some(&(phase as u32 + 1)));
        waiting.fold(own, |longest, other| longest.max(other.remaining_s))
    }

    /// A robot's phase.
    pub fn phase(&self, robot: usize, phase: u32) -> &Phase {
        &self.robots[robot].phases[phase as usize]
    }

    /// The graph that a robot moves on in a phase.
    pub fn graph(&self, robot: usize, phase: u32) -> &ModeGraph<'a> {
        &self.robots[robot].modes[self.phase(robot, phase).mode]
    }

    /// Ways on from a vertex in a phase, other phases' events not looked at.
    pub fn arcs(&self, robot: usize, phase: u32, vertex: VertexId) -> &[Arc] {
        &self.graph(robot, phase).arcs[vertex.index()]
    }

    /// Number of a motion.
    pub fn number(&self, motion: Motion) -> u32 {
        let graph = &self.robots[motion.robot].modes[motion.mode];
        match motion.arc {
            Some(arc) => graph.arcs[motion.from.index()][arc].motion,
            None => graph.stands[motion.from.index()],
        }
    }

    /// A motion with its configurations.
    pub fn timed(&self, motion: Motion) -> TimedEdge {
        let graph = &self.robots[motion.robot].modes[motion.mode];
        match motion.arc {
            Some(arc) => {
                let robot = &self.problem.robots[motion.robot];
                graph.timed_arc(robot, motion.from, &graph.arcs[motion.from.index()][arc])
            }
            None => graph.timed_stand(motion.from),
        }
    }

    /// Robot `robot`, in a phase, stays at a vertex for good.
    pub fn pin(&mut self, robot: usize, phase: u32, vertex: VertexId) {
        self.keep_in(robot, phase, vertex);
        let pinned = &mut self.robots[robot].phases[phase as usize];
        pinned.usable.iter_mut().enumerate().for_each(|(v, usable)| *usable = v == vertex.index());
    }

    /// Robot `robot` stays in a phase for good. It may make room for others; where it would rather be is at a vertex.
    pub fn keep_in(&mut self, robot: usize, phase: u32, vertex: VertexId) {
        let RobotRoadmap { modes, phases } = &mut self.robots[robot];
        phases.truncate(phase as usize + 1);
        let kept = &mut phases[phase as usize];
        // Nothing tells whether it might enter where its event would happen.
        kept.usable[kept.goal.index()] = kept.goal == vertex;
        (kept.goal, kept.enters) = (vertex, vertex);
        kept.events.clear();
        kept.needs.iter_mut().for_each(|needed| *needed = 0);
        kept.cost_to_go_s = modes[kept.mode].times_to(vertex, &kept.usable, |arc| arc.duration_s);
        kept.remaining_s = 0.0;
    }

    /// Makes the end of a robot's phase all that matters.
    pub fn aim_at(&mut self, robot: usize, phase: u32) {
        self.robots.iter_mut().flat_map(|robot| &mut robot.phases).for_each(|phase| phase.remaining_s = 0.0);
        let phases = &mut self.robots[robot].phases;
        for before in (0..phase as usize).rev() {
            let next = &phases[before + 1];
            let remaining_s =
                phases[before].rest_s + next.cost_to_go_s[phases[before].enters.index()] + next.remaining_s;
            phases[before].remaining_s = remaining_s;
        }
        self.aim = Some(Passed { robot, phase });
    }

    /// Upper bound on the number of composite vertices of these and all later phases, up to the aim.
    pub fn size(&self, from: impl Iterator<Item = u32>) -> f64 {
        let vertices = |(robot, from): (usize, u32)| {
            let is_aim = |aim: &Passed| aim.robot == robot;
            let phases = &self.robots[robot].phases;
            let until = self.aim.filter(is_aim).map_or(phases.len(), |aim| aim.phase as usize + 1);
            let usable = |phase: &Phase| phase.usable.iter().filter(|usable| **usable).count();
            phases[..until].iter().skip(from as usize).map(usable).sum::<usize>() as f64
        };
        from.enumerate().map(vertices).product()
    }
}

/// A robot's roadmaps; one more with a single vertex where no mode is left that it could be in at the end.
fn all_modes<'a>(
    problem: &Problem,
    skeleton: &Skeleton,
    robot: RobotId,
    roadmaps: &'a [Vec<ModeRoadmap>],
) -> Result<Vec<Cow<'a, ModeRoadmap>>, Interrupted> {
    let modes = &skeleton.modes[robot.index()];
    let given = roadmaps.get(robot.index()).map_or(&[][..], Vec::as_slice);
    if given.len() != modes.len() || given.iter().zip(modes).any(|(roadmap, mode)| roadmap.mode != mode.id) {
        return Err(Interrupted::Unfit(format!("not one roadmap for each mode of robot {}", robot.0)));
    }
    let mut all: Vec<Cow<'a, ModeRoadmap>> = given.iter().map(Cow::Borrowed).collect();
    if modes.last().is_none_or(|mode| mode.ends.is_some()) {
        let stands_at = match given.last() {
            Some(last) => last.vertices.get(last.goal.index()).cloned().unwrap_or_default(),
            None => problem.robot(robot).start.clone(),
        };
        all.push(Cow::Owned(ModeRoadmap {
            mode: ModeId { robot, step: modes.len() as u32 },
            holding: None,
            vertices: vec![stands_at],
            edges: Vec::new(),
            start: VertexId(0),
            goal: VertexId(0),
            parking: vec![VertexId(0)],
            possible: Vec::new(),
            cost_to_go_s: vec![0.0],
        }));
    }
    Ok(all)
}

fn final_stand(mode: usize, graph: &ModeGraph<'_>) -> Phase {
    Phase {
        mode,
        usable: vec![true],
        goal: graph.roadmap.goal,
        enters: graph.roadmap.goal,
        events: Vec::new(),
        rest_s: 0.0,
        needs: Vec::new(),
        cost_to_go_s: vec![0.0],
        remaining_s: 0.0,
    }
}
