//! Places of some hops, and how their pairs are done so far.

use std::collections::BTreeSet;

use contract::{DiscoveredOrder, HopChoice, Literal, PlacementCandidate, StageKind};
use skeleton::{ArcOrigin, Skeleton};

use crate::asking::misfit;
use crate::budgets::Budgets;
use crate::candidate::Candidate;
use crate::conflict::Halt;
use crate::search::Search;

/// The first hops of the sequence with their places.
pub(crate) struct Partial<'a> {
    /// Alternatives of the pairs that have their places.
    pub(crate) candidate: Candidate<'a>,
    /// Placements in the sequence of the hops, with every order that was added for them.
    pub(crate) placement: PlacementCandidate,
    /// Positions of the hops for which orders were added.
    pub(crate) ordering: BTreeSet<usize>,
}

impl<'a> Partial<'a> {
    /// No hop is placed.
    pub(crate) fn new(search: &Search<'a>, level: u32, budgets: Budgets<'a>, skeleton: &Skeleton) -> Self {
        let placement = PlacementCandidate { index: 0, placements: Vec::new(), orders: Vec::new() };
        let candidate = Candidate::new(search, level, budgets, skeleton.clone(), &placement);
        Self { candidate, placement, ordering: BTreeSet::new() }
    }

    /// Number of hops that are placed.
    pub(crate) fn len(&self) -> usize {
        self.placement.placements.len()
    }

    /// One more hop placed. Orders that contradict others are a fault of the stage that made them.
    pub(crate) fn with(&self, choice: HopChoice) -> Result<Self, Halt> {
        let (mut candidate, mut placement, mut ordering) =
            (self.candidate.clone(), self.placement.clone(), self.ordering.clone());
        for order in &choice.orders {
            let added = candidate.skeleton.graph.add(order.before, order.after, ArcOrigin::Discovered);
            added.map_err(|_| Halt::from(misfit(StageKind::Placement)))?;
        }
        if !choice.orders.is_empty() {
            ordering.insert(self.len());
        }
        let object = candidate.problem.pair(choice.placed.pair).object;
        candidate.poses[object.index()].push(choice.placed.world_from_object);
        candidate.samples[object.index()].push(choice.placed.sample);
        candidate.orders.extend(choice.orders.iter().cloned());
        placement.orders.extend(choice.orders);
        placement.placements.push(choice.placed);
        Ok(Self { candidate, placement, ordering })
    }

    /// Whether a literal holds of it.
    pub(crate) fn holds(&self, literal: &Literal) -> bool {
        match literal {
            Literal::Pose { occupancy, sample } => self.placement.placements.iter().any(|placed| {
                let pair = self.candidate.problem.pair(placed.pair);
                (pair.object, pair.hop, placed.sample) == (occupancy.object, occupancy.hop, *sample)
            }),
            Literal::Order { before, after } => self.candidate.skeleton.graph.precedes(*before, *after),
            Literal::Alternative { .. } => false,
        }
    }

    /// The placement candidate that it is when every hop is placed: pairs in their order, and of the orders those that
    /// neither `skeleton` nor the others imply.
    pub(crate) fn whole(&self, index: u32, skeleton: &Skeleton) -> PlacementCandidate {
        let mut placements = self.placement.placements.clone();
        placements.sort_by_key(|placed| placed.pair);
        let orders = &self.placement.orders;
        let is_implied = |i: usize| {
            let mut graph = skeleton.graph.clone();
            let others = orders.iter().enumerate().filter(|(other, _)| *other != i).map(|(_, order)| order);
            // They hold together already.
            others.for_each(|order| drop(graph.add(order.before, order.after, ArcOrigin::Discovered)));
            graph.precedes(orders[i].before, orders[i].after)
        };
        let mut orders: Vec<DiscoveredOrder> =
            (0..orders.len()).filter(|i| !is_implied(*i)).map(|i| orders[i].clone()).collect();
        orders.sort_by_key(|order| (order.before, order.after));
        PlacementCandidate { index, placements, orders }
    }
}
