//! The rules of composite motion: what each robot may do in a composite state, and whether they may do it together.
//!
//! In one composite step every robot stays, travels one edge, or has its event and then rests. Events happen at the
//! beginning of the step, motions begin then too, each at its own pace; the step ends when all have arrived, those that
//! arrive early standing at their vertex.

use std::collections::HashMap;

use contract::VertexId;

use super::composite_roadmap::{CompositeRoadmap, Motion, Passed};
use super::mode_graph::Arc;
use super::mode_vector::{ModeVector, ModeVectors, VectorId};
use super::phase::Phase;
use super::validity::CompositeValidity;

/// A vertex of the composite roadmap.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct State {
    pub vector: VectorId,
    pub vertices: Vec<VertexId>,
}

/// What one robot does in a composite step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Act {
    /// Stands.
    Stay,
    /// Travels this arc of its vertex.
    Along(usize),
    /// Its phase ends here and now; it rests in the next one.
    Event,
}

/// A composite edge that keeps all rules.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Step {
    pub to: State,
    pub duration_s: f64,
}

/// Why robots may not do something together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refused {
    /// One robot alone may not do it: its gate is shut, or an object is in its way.
    Alone(usize),
    /// Two robots would come too close.
    Pair(usize, usize),
}

/// The rules, with everything asked of geometry remembered.
pub(super) struct Rules<'a, V> {
    pub roadmap: &'a CompositeRoadmap<'a>,
    pub vectors: ModeVectors,
    validity: &'a V,
    /// By the numbers of two motions. Only looked up, never walked through.
    conflicts: HashMap<(u32, u32), bool>,
    /// By the numbers of a standing motion and an occupancy.
    hits: HashMap<(u32, u32), bool>,
}

impl<'a, V: CompositeValidity> Rules<'a, V> {
    pub fn new(roadmap: &'a CompositeRoadmap<'a>, validity: &'a V) -> Self {
        let (conflicts, hits) = (HashMap::new(), HashMap::new());
        Self { roadmap, vectors: ModeVectors::default(), validity, conflicts, hits }
    }

    pub fn vector(&self, state: &State) -> &ModeVector {
        self.vectors.get(state.vector)
    }

    /// The ways on from a robot's vertex.
    pub fn arcs(&self, state: &State, robot: usize) -> &'a [Arc] {
        self.roadmap.arcs(robot, self.vector(state).phases[robot], state.vertices[robot])
    }

    /// Whether the aim is reached: all robots are at the end of their last phases, if nothing else is aimed at.
    pub fn is_final(&self, state: &State) -> bool {
        if let Some(aim) = self.roadmap.aim {
            return self.is_reached(aim, state) && !self.counts_on_an_arrival(state);
        }
        let vector = self.vector(state);
        (0..state.vertices.len()).all(|robot| {
            let phase = vector.phases[robot];
            phase as usize + 1 == self.roadmap.robots[robot].phases.len()
                && state.vertices[robot] == self.roadmap.phase(robot, phase).goal
        })
    }

    /// Whether a point is passed; of a last phase, whether the robot is at its end.
    pub fn is_reached(&self, aim: Passed, state: &State) -> bool {
        let at = self.vector(state).phases[aim.robot];
        let phase = self.roadmap.phase(aim.robot, aim.phase);
        at > aim.phase || at == aim.phase && phase.events.is_empty() && state.vertices[aim.robot] == phase.goal
    }

    /// Whether an event counts on a robot's having come to where its mode ends, and that mode has not ended: when the robot
    /// comes there is then not settled yet.
    fn counts_on_an_arrival(&self, state: &State) -> bool {
        let phases = &self.vector(state).phases;
        let over = |robot: usize| &self.roadmap.robots[robot].phases[..phases[robot] as usize];
        (0..phases.len()).any(|robot| {
            let mode = self.roadmap.phase(robot, phases[robot]).mode;
            let arrived = over(robot).iter().rposition(|phase| phase.mode == mode && phase.is_arrival());
            let counts = |phase: &Phase, arrival: usize| phase.needs.get(robot).is_some_and(|n| *n as usize > arrival);
            arrived.is_some_and(|arrival| (0..phases.len()).any(|other| over(other).iter().any(|p| counts(p, arrival))))
        })
    }

    /// Whether the robot's event may happen where it stands.
    pub fn has_event(&self, state: &State, robot: usize) -> bool {
        let vector = self.vector(state);
        let phase = self.roadmap.phase(robot, vector.phases[robot]);
        vector.open[robot] && state.vertices[robot] == phase.goal && !phase.events.is_empty()
    }

    /// Whether the robot may travel an arc, other robots and objects that can move not looked at: it stays within its
    /// phase, and enters the goal only when all that must come before has happened.
    pub fn may_enter(&self, vector: VectorId, robot: usize, arc: &Arc) -> bool {
        let vector = self.vectors.get(vector);
        let phase = self.roadmap.phase(robot, vector.phases[robot]);
        phase.usable[arc.to.index()] && (arc.to != phase.goal || vector.open[robot])
    }

    /// Whether no standing object is in the way.
    pub fn is_clear(&self, vector: VectorId, arc: &Arc) -> bool {
        let present = &self.vectors.get(vector).present;
        arc.blockers.iter().all(|occupancy| !present[*occupancy as usize])
    }

    /// What a robot could do by itself: stay, its event, and all arcs it may travel with objects as they stand.
    pub fn acts(&self, state: &State, robot: usize) -> Vec<Act> {
        let mut acts = vec![Act::Stay];
        if self.has_event(state, robot) {
            acts.push(Act::Event);
        }
        let travels =
            |(_, arc): &(usize, &Arc)| self.may_enter(state.vector, robot, arc) && self.is_clear(state.vector, arc);
        acts.extend(self.arcs(state, robot).iter().enumerate().filter(travels).map(|(i, _)| Act::Along(i)));
        acts
    }

    /// The mode vector once the events among `acts` have happened.
    pub fn after_events(&mut self, state: &State, acts: &[Act]) -> VectorId {
        if acts.iter().all(|act| *act != Act::Event) {
            return state.vector;
        }
        let phases = &self.vectors.get(state.vector).phases;
        let after: Vec<u32> = phases.iter().zip(acts).map(|(p, act)| p + u32::from(*act == Act::Event)).collect();
        self.vectors.number(self.roadmap, &after)
    }

    /// What a robot does as a motion, `vector` being in force during the step.
    pub fn motion(&self, state: &State, vector: VectorId, robot: usize, act: Act) -> Motion {
        let before = self.vectors.get(state.vector).phases[robot];
        let phase = self.vectors.get(vector).phases[robot];
        let mode = self.roadmap.phase(robot, phase).mode;
        match act {
            Act::Stay => Motion { robot, mode, from: state.vertices[robot], arc: None },
            Act::Along(arc) => Motion { robot, mode, from: state.vertices[robot], arc: Some(arc) },
            Act::Event => Motion { robot, mode, from: self.roadmap.phase(robot, before).enters, arc: None },
        }
    }

    /// Whether one robot may do its part: enter where it goes, with no object in its way once the events have happened,
    /// and no object newly placed on it.
    pub fn may_alone(&mut self, state: &State, vector: VectorId, robot: usize, act: Act) -> bool {
        if let Act::Along(index) = act {
            let arc = &self.arcs(state, robot)[index];
            return self.may_enter(state.vector, robot, arc) && self.is_clear(vector, arc);
        }
        if act == Act::Event && !self.has_event(state, robot) {
            return false;
        }
        if vector == state.vector {
            return true;
        }
        let motion = self.motion(state, vector, robot, act);
        (0..self.roadmap.stays.len()).all(|occupancy| {
            let is_new =
                self.vectors.get(vector).present[occupancy] && !self.vectors.get(state.vector).present[occupancy];
            let placed_by = self.roadmap.stays[occupancy].from.map(|passed| passed.robot);
            !is_new || placed_by == Some(robot) || !self.stand_hits(motion, occupancy as u32)
        })
    }

    /// Whether a standing robot is hit by an object at one of its poses.
    pub fn stand_hits(&mut self, stand: Motion, occupancy: u32) -> bool {
        let graph = &self.roadmap.robots[stand.robot].modes[stand.mode];
        // Any edge proves its ends.
        if graph.arcs[stand.from.index()].iter().any(|arc| !arc.blockers.contains(&occupancy)) {
            return false;
        }
        let (roadmap, validity) = (self.roadmap, self.validity);
        *self
            .hits
            .entry((roadmap.number(stand), occupancy))
            .or_insert_with(|| validity.stand_hits(&roadmap.timed(stand), roadmap.stays[occupancy as usize].occupancy))
    }

    /// Whether two robots that do these motions at the same time come too close.
    pub fn conflict(&mut self, a: Motion, b: Motion) -> bool {
        let (a, b) = if a.robot < b.robot { (a, b) } else { (b, a) };
        let (roadmap, validity) = (self.roadmap, self.validity);
        let key = (roadmap.number(a), roadmap.number(b));
        *self.conflicts.entry(key).or_insert_with(|| validity.edges_conflict(&roadmap.timed(a), &roadmap.timed(b)))
    }

    /// How long a robot's part of a step takes (s).
    pub fn duration_s(&self, state: &State, robot: usize, act: Act) -> f64 {
        match act {
            Act::Stay => 0.0,
            Act::Along(arc) => self.arcs(state, robot)[arc].duration_s,
            Act::Event => self.roadmap.phase(robot, self.vector(state).phases[robot]).rest_s,
        }
    }

    /// Where a step leads, no rule looked at.
    pub fn step(&mut self, state: &State, acts: &[Act]) -> Step {
        let vector = self.after_events(state, acts);
        let mut vertices = state.vertices.clone();
        let mut duration_s: f64 = 0.0;
        for (robot, act) in acts.iter().enumerate() {
            match *act {
                Act::Stay => {}
                Act::Along(arc) => vertices[robot] = self.arcs(state, robot)[arc].to,
                Act::Event => {
                    vertices[robot] = self.roadmap.phase(robot, self.vector(state).phases[robot]).enters;
                }
            }
            duration_s = duration_s.max(self.duration_s(state, robot, *act));
        }
        Step { to: State { vector, vertices }, duration_s }
    }

    /// A step with all its rules checked.
    ///
    /// # Errors
    /// The first rule that it breaks.
    pub fn checked_step(&mut self, state: &State, acts: &[Act]) -> Result<Step, Refused> {
        let vector = self.after_events(state, acts);
        for (robot, act) in acts.iter().enumerate() {
            if !self.may_alone(state, vector, robot, *act) {
                return Err(Refused::Alone(robot));
            }
        }
        for b in 0..acts.len() {
            for a in 0..b {
                if self.would_meet(state, vector, (a, acts[a]), (b, acts[b])) {
                    return Err(Refused::Pair(a, b));
                }
            }
        }
        Ok(self.step(state, acts))
    }

    /// Whether two robots' parts of a step bring them too close. Robots that both just stay are as they were.
    pub fn would_meet(&mut self, state: &State, vector: VectorId, a: (usize, Act), b: (usize, Act)) -> bool {
        if a.1 == Act::Stay && b.1 == Act::Stay {
            return false;
        }
        let (first, second) = (self.motion(state, vector, a.0, a.1), self.motion(state, vector, b.0, b.1));
        self.conflict(first, second)
    }
}
