//! Proofs that no placement exists, whatever the samples.
//!
//! 1. An object is larger than its region at every yaw.
//! 2. Two objects together are larger than their region, so that one must leave before the other comes; all such
//!    needs together contradict the given order.
//! 3. Objects that are in a region at the same time in every execution are together larger than it.

use contract::{CauseTally, FailureReport};
use model::Problem;
use plan::{Cause, Certificate};
use skeleton::Cycle;

use crate::contradiction::{contradiction, given_cycle};
use crate::footprint::Rectangle;
use crate::guests::Guests;
use crate::layout::{Layout, Site};
use crate::outline::Outline;
use crate::report;

/// Why the problem has no placement, if that can be proven.
pub(crate) fn impossible(problem: &Problem, layout: &Layout) -> Option<FailureReport> {
    too_large(problem, layout)
        .or_else(|| contradiction(problem, layout))
        .or_else(|| overfull(problem, layout))
        .map(proven)
}

/// Why there is no plan with orderings that contradict one another.
pub(crate) fn cyclic(problem: &Problem, cycle: &Cycle) -> FailureReport {
    proven(given_cycle(problem, cycle))
}

fn proven((causes, certificate): (Vec<Cause>, Certificate)) -> FailureReport {
    let mut tally = CauseTally::default();
    causes.into_iter().for_each(|cause| tally.count(cause));
    FailureReport::infeasible(tally, certificate)
}

fn too_large(problem: &Problem, layout: &Layout) -> Option<(Vec<Cause>, Certificate)> {
    let site = layout.sites.iter().find(|site| is_too_large(problem, site))?;
    let cause = report::no_placement(problem, site)?;
    let Cause::NoPlacement { object, region } = cause.clone() else { return None };
    Some((vec![cause], Certificate::ObjectTooLarge { object, region }))
}

fn is_too_large(problem: &Problem, site: &Site) -> bool {
    let Some(region) = site.region(problem) else { return false };
    let rectangle = Rectangle::new(&problem.regions[region.index()], &problem.settings);
    Outline::new(&problem.movable[site.object().index()].body).never_fits(&rectangle)
}

fn overfull(problem: &Problem, layout: &Layout) -> Option<(Vec<Cause>, Certificate)> {
    Guests::of_regions(problem, layout).find_map(|guests| {
        let crowd = (0..guests.sites.len()).find_map(|seed| crowd(layout, &guests, seed))?;
        let placed = crowd.iter().filter_map(|(site, _)| report::no_placement(problem, &layout.sites[*site]));
        let certificate = Certificate::Area {
            region: problem.regions[guests.region.index()].name.clone(),
            region_area_m2: guests.region_area_m2,
            stays: crowd.iter().map(|guest| Guests::cover(problem, layout, *guest)).collect(),
            together: together(problem, layout, &crowd),
        };
        let causes: Vec<Cause> = placed.collect();
        (!causes.is_empty()).then_some((causes, certificate))
    })
}

/// Sites that are taken at the same time in every execution and that are too large together, grown from one of them.
fn crowd(layout: &Layout, guests: &Guests, seed: usize) -> Option<Vec<(usize, f64)>> {
    let mut members = vec![guests.sites[seed]];
    for guest in &guests.sites {
        if guests.exceed(members.iter().map(|(_, area)| area).sum()) {
            return Some(members);
        }
        if members.iter().all(|(member, _)| always_together(layout, *member, guest.0)) {
            members.push(*guest);
        }
    }
    guests.exceed(members.iter().map(|(_, area)| area).sum()).then_some(members)
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

/// That each site of a crowd is taken before any other is left.
fn together(problem: &Problem, layout: &Layout, crowd: &[(usize, f64)]) -> Vec<[plan::PairPoint; 2]> {
    let ends = |(first, _): &(usize, f64), (second, _): &(usize, f64)| {
        let (comes, leaves) = layout.sites[*first].comes.zip(layout.sites[*second].leaves)?;
        (first != second).then(|| [report::point(problem, comes), report::point(problem, leaves)])
    };
    crowd.iter().flat_map(|first| crowd.iter().filter_map(move |second| ends(first, second))).collect()
}
