//! Mode vectors: how far every robot is, and what follows from it: which objects stand where, which gates are open.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::composite_roadmap::{CompositeRoadmap, Passed};

/// Added to the time of an edge that an object blocks (s): an oracle then prefers any way round, and comes near if there is none.
pub(super) const BLOCKED_S: f64 = 1e5;

/// The phases of all robots, and what they imply.
#[derive(Clone, Debug)]
pub(super) struct ModeVector {
    /// Phase of each robot.
    pub phases: Vec<u32>,
    /// Which poses of objects are occupied.
    pub present: Vec<bool>,
    /// Whether each robot's event may happen (in the last phase: always).
    pub open: Vec<bool>,
    /// Number of phases that are over.
    pub advance: u32,
    /// For each robot and vertex, least time to its phase's goal, objects as they stand (s; [`BLOCKED_S`] more for each blocked edge).
    pub times_to_go_s: Vec<Rc<Vec<f64>>>,
}

impl ModeVector {
    /// Whether a passed point lies behind.
    fn has_passed(&self, passed: Passed) -> bool {
        self.phases[passed.robot] > passed.phase
    }
}

/// A mode vector's number.
pub(super) type VectorId = usize;

/// All mode vectors met so far.
#[derive(Debug, Default)]
pub(super) struct ModeVectors {
    all: Vec<ModeVector>,
    known: BTreeMap<Vec<u32>, VectorId>,
    times: BTreeMap<TimesKey, Rc<Vec<f64>>>,
}

/// Robot, phase, and the occupied poses among those that block anything there.
type TimesKey = (usize, u32, Vec<u32>);

impl ModeVectors {
    /// The number of the vector with these phases.
    pub fn number(&mut self, roadmap: &CompositeRoadmap<'_>, phases: &[u32]) -> VectorId {
        if let Some(known) = self.known.get(phases) {
            return *known;
        }
        let vector = self.make(roadmap, phases);
        self.all.push(vector);
        let number = self.all.len() - 1;
        self.known.insert(phases.to_vec(), number);
        number
    }

    /// A vector by its number.
    pub fn get(&self, number: VectorId) -> &ModeVector {
        &self.all[number]
    }

    fn make(&mut self, roadmap: &CompositeRoadmap<'_>, phases: &[u32]) -> ModeVector {
        let mut vector = ModeVector {
            phases: phases.to_vec(),
            present: Vec::new(),
            open: Vec::new(),
            advance: phases.iter().sum(),
            times_to_go_s: Vec::new(),
        };
        let passed = |passed: Option<Passed>, missing: bool| passed.map_or(missing, |passed| vector.has_passed(passed));
        let present = roadmap.stays.iter().map(|stay| passed(stay.from, true) && !passed(stay.until, false)).collect();
        vector.present = present;
        vector.open = (0..phases.len())
            .map(|robot| {
                let needs = &roadmap.phase(robot, phases[robot]).needs;
                needs.iter().zip(phases).all(|(needed, phase)| phase >= needed)
            })
            .collect();
        vector.times_to_go_s = (0..phases.len()).map(|robot| self.times(roadmap, robot, &vector)).collect();
        vector
    }

    fn times(&mut self, roadmap: &CompositeRoadmap<'_>, robot: usize, vector: &ModeVector) -> Rc<Vec<f64>> {
        let phase = vector.phases[robot];
        let graph = roadmap.graph(robot, phase);
        let mut blocking: Vec<u32> = graph.arcs.iter().flatten().flat_map(|arc| &arc.blockers).copied().collect();
        blocking.sort_unstable();
        blocking.dedup();
        blocking.retain(|occupancy| vector.present[*occupancy as usize]);
        let key = (robot, phase, blocking);
        let times = self.times.entry(key).or_insert_with_key(|(_, _, blocking)| {
            let phase = roadmap.phase(robot, phase);
            let blocked = |blockers: &[u32]| blockers.iter().any(|b| blocking.binary_search(b).is_ok());
            let cost = |arc: &super::mode_graph::Arc| {
                if blocked(&arc.blockers) { arc.duration_s + BLOCKED_S } else { arc.duration_s }
            };
            Rc::new(graph.times_to(phase.goal, &phase.usable, cost))
        });
        Rc::clone(times)
    }
}
