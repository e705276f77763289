//! Proofs that no placement exists, whatever the samples.
//!
//! 1. An object is larger than its region at every yaw.
//! 2. Two objects together are larger than their region, so that one must leave before the other comes; all such
//!    needs together contradict the given order.
//! 3. Objects that are in a region at the same time in every execution are together larger than it.

use contract::{CauseTally, FailureReport, Soundness};
use model::{Problem, RegionId};
use plan::Cause;
use skeleton::{ArcOrigin, Cycle, EventGraph};

use crate::footprint::{Footprint, Rectangle};
use crate::layout::{Layout, Site};
use crate::outline::{Outline, is_upright};
use crate::report;

/// Branchings after which the search for a contradiction is given up.
const MOST_BRANCHINGS: u32 = 2_000;

/// Why the problem has no placement, if that can be proven.
pub(crate) fn impossible(problem: &Problem, layout: &Layout) -> Option<FailureReport> {
    let causes =
        too_large(problem, layout).or_else(|| contradiction(problem, layout)).or_else(|| overfull(problem, layout))?;
    Some(proven(causes))
}

/// A failure that more samples cannot mend.
pub(crate) fn proven(causes: Vec<Cause>) -> FailureReport {
    let mut tally = CauseTally::default();
    causes.into_iter().for_each(|cause| tally.count(cause));
    FailureReport { causes: tally.ranked(), soundness: Soundness::Hard, certificate: None }
}

fn too_large(problem: &Problem, layout: &Layout) -> Option<Vec<Cause>> {
    let causes: Vec<Cause> = layout
        .sites
        .iter()
        .filter(|site| is_too_large(problem, site))
        .filter_map(|site| report::no_placement(problem, site))
        .collect();
    (!causes.is_empty()).then_some(causes)
}

fn is_too_large(problem: &Problem, site: &Site) -> bool {
    let Some(region) = site.region(problem) else { return false };
    let rectangle = Rectangle::new(&problem.regions[region.index()], &problem.settings);
    Outline::new(&problem.movable[site.object().index()].body).never_fits(&rectangle)
}

/// Sites whose bodies stand wholly inside of one region's rectangle, with the areas (m²) they cover there.
struct Guests {
    rectangle_area: f64,
    guests: Vec<(usize, f64)>,
}

impl Guests {
    fn of(problem: &Problem, layout: &Layout, region: RegionId) -> Self {
        let rectangle = Rectangle::new(&problem.regions[region.index()], &problem.settings);
        let inside = |site: &Site| match site.region(problem) {
            Some(to) => to == region,
            None => starts_inside(problem, site, region, &rectangle),
        };
        let area = |site: &Site| Outline::new(&problem.movable[site.object().index()].body).prism_area();
        let sites = layout.sites.iter().enumerate().filter(|(_, site)| inside(site));
        let guests = sites.filter_map(|(index, site)| Some((index, area(site)?))).collect();
        Self { rectangle_area: rectangle.area(), guests }
    }

    fn exceed(&self, area: f64) -> bool {
        area > self.rectangle_area * (1.0 + 1e-9)
    }
}

fn starts_inside(problem: &Problem, site: &Site, region: RegionId, rectangle: &Rectangle) -> bool {
    let object = &problem.movable[site.object().index()];
    let region_from_object = problem.regions[region.index()].world_from_region.inverse() * object.world_from_start;
    let height = region_from_object.translation.z - object.origin_height();
    let yaw = region_from_object.rotation.euler_angles().2;
    let at = [region_from_object.translation.x, region_from_object.translation.y];
    let room = Footprint::of(object).room(rectangle, yaw);
    is_upright(&region_from_object)
        && height.abs() <= problem.settings.support_tolerance
        && room.is_some_and(|room| (0..2).all(|i| (room.least[i]..=room.greatest[i]).contains(&at[i])))
}

fn regions(problem: &Problem) -> impl Iterator<Item = RegionId> + use<> {
    (0..problem.regions.len()).map(RegionId::at)
}

/// Pairs of sites of one region that collide wherever the two objects stand in it.
fn always_colliding(problem: &Problem, layout: &Layout) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    for region in regions(problem) {
        let guests = Guests::of(problem, layout, region);
        for (i, (a, area)) in guests.guests.iter().enumerate() {
            for (b, other) in &guests.guests[i + 1..] {
                if layout.neighbours[*a].contains(b) && guests.exceed(area + other) {
                    pairs.push((*a, *b));
                }
            }
        }
    }
    pairs
}

fn contradiction(problem: &Problem, layout: &Layout) -> Option<Vec<Cause>> {
    let pairs = always_colliding(problem, layout);
    let mut search = Contradiction { layout, pairs: &pairs, branchings: 0 };
    let ((a, b), cycle) = search.settle(&mut layout.graph.clone())?;
    let sites = [a, b].map(|site| &layout.sites[site]);
    let placed = sites.into_iter().filter_map(|site| report::no_placement(problem, site));
    Some(placed.chain([report::cycle(problem, &cycle)]).collect())
}

/// Searches for an order on events that keeps every pair apart.
struct Contradiction<'a> {
    layout: &'a Layout,
    pairs: &'a [(usize, usize)],
    branchings: u32,
}

impl Contradiction<'_> {
    /// A pair that cannot be kept apart, and a cycle that this would close; `None`: no contradiction was found.
    fn settle(&mut self, graph: &mut EventGraph) -> Option<((usize, usize), Cycle)> {
        loop {
            let mut open = None;
            let mut settled = 0;
            for (a, b) in self.pairs.iter().copied() {
                if !self.layout.may_coexist(graph, a, b) {
                    continue;
                }
                let ways = [(a, b), (b, a)].map(|(first, second)| self.add(graph, first, second));
                match ways {
                    [Way::Closes(cycle), Way::Closes(_) | Way::None] | [Way::None, Way::Closes(cycle)] => {
                        return Some(((a, b), cycle));
                    }
                    [Way::None, Way::None] => {}
                    [Way::Open, Way::Open] => open = open.or(Some((a, b))),
                    [Way::Open, _] => settled += self.commit(graph, a, b),
                    [_, Way::Open] => settled += self.commit(graph, b, a),
                }
            }
            if settled == 0 {
                return self.branch(graph, open?);
            }
        }
    }

    fn branch(&mut self, graph: &mut EventGraph, (a, b): (usize, usize)) -> Option<((usize, usize), Cycle)> {
        self.branchings += 1;
        if self.branchings > MOST_BRANCHINGS {
            return None;
        }
        let mut contradiction = None;
        for (first, second) in [(a, b), (b, a)] {
            let checkpoint = graph.checkpoint();
            self.commit(graph, first, second);
            contradiction = Some(self.settle(graph)?);
            graph.undo(checkpoint);
        }
        contradiction
    }

    fn add(&self, graph: &mut EventGraph, first: usize, second: usize) -> Way {
        let Some((before, after)) = self.layout.order_events(first, second) else { return Way::None };
        let checkpoint = graph.checkpoint();
        let added = graph.add(before, after, ArcOrigin::Discovered);
        graph.undo(checkpoint);
        added.map_or_else(Way::Closes, |()| Way::Open)
    }

    /// Adds an order that closes no cycle; counts it.
    fn commit(&self, graph: &mut EventGraph, first: usize, second: usize) -> u32 {
        let events = self.layout.order_events(first, second);
        u32::from(events.is_some_and(|(before, after)| graph.add(before, after, ArcOrigin::Discovered).is_ok()))
    }
}

/// What putting one site before another does.
enum Way {
    /// One never comes, or the other never leaves.
    None,
    /// It closes a cycle.
    Closes(Cycle),
    /// It is possible.
    Open,
}

fn overfull(problem: &Problem, layout: &Layout) -> Option<Vec<Cause>> {
    regions(problem).find_map(|region| {
        let mut guests = Guests::of(problem, layout, region);
        guests.guests.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let crowds = (0..guests.guests.len()).map(|seed| crowd(layout, &guests.guests, seed));
        let crowd = crowds.into_iter().find(|(_, area)| guests.exceed(*area))?.0;
        let causes: Vec<Cause> =
            crowd.into_iter().filter_map(|site| report::no_placement(problem, &layout.sites[site])).collect();
        (!causes.is_empty()).then_some(causes)
    })
}

/// Sites that are taken at the same time in every execution, grown from one of them, largest first; and their area.
fn crowd(layout: &Layout, guests: &[(usize, f64)], seed: usize) -> (Vec<usize>, f64) {
    let (mut members, mut area) = (vec![guests[seed].0], guests[seed].1);
    for (site, more) in guests {
        if !members.contains(site) && members.iter().all(|member| always_together(layout, *member, *site)) {
            members.push(*site);
            area += more;
        }
    }
    (members, area)
}

/// Whether two sites of different objects are taken at the same time in every execution: each comes before the other
/// leaves. Sites of one object never are.
fn always_together(layout: &Layout, a: usize, b: usize) -> bool {
    let comes_before_leaving =
        |first: usize, second: usize| match (layout.sites[first].comes, layout.sites[second].leaves) {
            (Some(comes), Some(leaves)) => layout.graph.precedes(comes, leaves),
            _ => true,
        };
    layout.sites[a].object() != layout.sites[b].object() && comes_before_leaving(a, b) && comes_before_leaving(b, a)
}
