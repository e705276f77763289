//! What is known of the modes of a candidate: roadmaps, alternatives without a way, poses that nothing keeps away. All of it
//! rests on poses and orderings that are named, so it stays known when other orderings are tried.

use std::collections::{BTreeMap, BTreeSet};

use contract::{CauseTally, JobId, ProductRef};
use skeleton::{Mode, Occupancy};

use crate::around::Around;
use crate::candidate::Candidate;
use crate::conflict::{Choice, Conflict, Order};

/// The alternatives of the pairs at the two ends of a mode, by their place among those offered. `None`: whichever.
pub(crate) type Ends = [Option<usize>; 2];

/// Roadmap of a mode.
#[derive(Clone, Debug)]
pub(crate) struct ModeAnswer {
    pub(crate) roadmap: ProductRef,
    pub(crate) shortest_s: f64,
    /// Possible poses that are in every way.
    pub(crate) in_the_way: Vec<Occupancy>,
}

/// A mode that has no way.
#[derive(Clone, Debug)]
pub(crate) struct NoWay {
    pub(crate) ends: Ends,
    /// As long as all of these are certain.
    pub(crate) certain: BTreeSet<Occupancy>,
    /// Other choices it rests on.
    pub(crate) choices: BTreeSet<Choice>,
    /// As long as all of these orderings hold.
    pub(crate) orders: BTreeSet<Order>,
    pub(crate) causes: CauseTally,
    pub(crate) proof: Option<JobId>,
}

/// A pose in the way of a mode that no ordering keeps away.
#[derive(Clone, Debug)]
pub(crate) struct Assumed {
    pub(crate) pose: Occupancy,
    /// As long as all of these orderings hold.
    pub(crate) orders: BTreeSet<Order>,
    /// Choices on which it rests that no ordering does.
    pub(crate) choices: BTreeSet<Choice>,
    pub(crate) causes: CauseTally,
}

/// What is known of one mode.
#[derive(Clone, Debug, Default)]
pub(crate) struct Known {
    pub(crate) no_ways: Vec<NoWay>,
    /// Roadmaps by the alternatives at the ends, and what was about when they were made.
    ways: BTreeMap<Ends, (Around, ModeAnswer)>,
    pub(crate) assumed: Vec<Assumed>,
}

impl Known {
    pub(crate) fn add_way(&mut self, ends: Ends, around: Around, answer: ModeAnswer) {
        self.ways.insert(ends, (around, answer));
    }

    /// The roadmap for these alternatives, if it is known for what is about now.
    pub(crate) fn way(&self, ends: Ends, around: &Around) -> Option<&ModeAnswer> {
        self.ways.get(&ends).filter(|(then, _)| then == around).map(|(_, answer)| answer)
    }

    /// All roadmaps for what is about now.
    pub(crate) fn ways<'a>(&'a self, around: &'a Around) -> impl Iterator<Item = (Ends, &'a ModeAnswer)> + 'a {
        let of_now = self.ways.iter().filter(move |(_, (then, _))| then == around);
        of_now.map(|(ends, (_, answer))| (*ends, answer))
    }
}

impl Candidate<'_> {
    pub(crate) fn known(&self, mode: &Mode) -> &Known {
        &self.known[mode.id.robot.index()][mode.id.step as usize]
    }

    pub(crate) fn known_mut(&mut self, mode: &Mode) -> &mut Known {
        &mut self.known[mode.id.robot.index()][mode.id.step as usize]
    }

    /// What leaves a mode without a way now.
    pub(crate) fn no_ways_now<'a>(
        &'a self,
        mode: &'a Mode,
        around: &'a Around,
    ) -> impl Iterator<Item = &'a NoWay> + 'a {
        let holds = |no_way: &&NoWay| no_way.certain.is_subset(&around.certain) && self.hold(&no_way.orders);
        self.known(mode).no_ways.iter().filter(holds)
    }

    /// Why a pose is to be reckoned with throughout a mode.
    pub(crate) fn why_certain(&self, mode: &Mode, occupancy: Occupancy) -> Conflict {
        let mut why = Conflict::of([Choice::Pose(occupancy)], &[], None);
        let assumed = self.known(mode).assumed.iter().find(|a| a.pose == occupancy && self.hold(&a.orders));
        match assumed {
            Some(assumed) => {
                why.choices.extend(&assumed.choices);
                why.orders.extend(&assumed.orders);
                why.causes = assumed.causes.clone();
            }
            None => why.orders = self.orders_keeping(occupancy, mode.interval()),
        }
        why
    }
}
