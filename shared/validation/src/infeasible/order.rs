//! Certificates about order: objects that are together, and contradictions.

use model::Problem;
use plan::{Cover, CycleArc, CycleOrigin, Exclusion, PairPoint};

use crate::infeasible::named::{self, Occupation};
use crate::infeasible::room::check_crowd;
use crate::precedence::{At, Precedence, gates};

/// Most steps of the search for an order that no listed contradiction forbids.
const MOST_STEPS: u64 = 1_000_000;

/// Stays that overlap in every execution cover more than there is.
pub(crate) fn check_area(
    problem: &Problem,
    region: &str,
    region_area: f64,
    stays: &[Cover],
    together: &[[PairPoint; 2]],
) -> Result<(), String> {
    let order = Precedence::given(problem);
    let mut known: Vec<[At; 2]> = Vec::new();
    for [before, after] in together {
        let pair = [named::point(problem, before)?, named::point(problem, after)?];
        if !order.precedes(pair[0], pair[1]) {
            return Err(format!("{} does not follow from {} as it should", words(before), words(after)));
        }
        known.push(pair);
    }
    let crowd = stays.iter().map(|cover| Ok((Occupation::of(problem, &cover.stay)?, cover.area_m2)));
    let crowd = crowd.collect::<Result<Vec<_>, String>>()?;
    for (first, _) in &crowd {
        for (second, _) in crowd.iter().filter(|(second, _)| second != first) {
            let (Some(comes), Some(leaves)) = (first.comes, second.leaves) else { continue };
            if !known.contains(&[comes, leaves]) {
                let name = |stay: &Occupation| problem.movable[stay.object.index()].name.clone();
                return Err(format!("{} may have left before {} comes", name(second), name(first)));
            }
        }
    }
    check_crowd(problem, named::region(problem, region)?, region_area, &crowd)
}

fn words(at: &PairPoint) -> String {
    format!("{} of {}", at.point.name(), at.pair)
}

/// Two ways to keep the stays of an exclusion apart, as arcs; none where a stay never ends, or the other was there first.
type Ways = [Option<(At, At)>; 2];

/// Every way to order the exclusions has a contradiction.
pub(crate) fn check_cycles(
    problem: &Problem,
    exclusions: &[Exclusion],
    cycles: &[Vec<CycleArc>],
) -> Result<(), String> {
    let ways = exclusions.iter().map(|exclusion| ways_of(problem, exclusion)).collect::<Result<Vec<_>, _>>()?;
    let clauses = cycles.iter().map(|arcs| clause(problem, &ways, arcs)).collect::<Result<Vec<_>, _>>()?;
    let mut search = Orders { ways: &ways, clauses: &clauses, taken: Vec::new(), steps: 0 };
    if search.escapes() {
        return Err(match search.steps {
            MOST_STEPS.. => "there are too many ways to order the objects".to_owned(),
            _ => "the objects can be ordered in a way that none of the cycles forbids".to_owned(),
        });
    }
    Ok(())
}

fn ways_of(problem: &Problem, exclusion: &Exclusion) -> Result<Ways, String> {
    let [first, second] = &exclusion.stays;
    let stays = [Occupation::of(problem, &first.stay)?, Occupation::of(problem, &second.stay)?];
    let crowd = [(stays[0], first.area_m2), (stays[1], second.area_m2)];
    check_crowd(problem, named::region(problem, &exclusion.region)?, exclusion.region_area_m2, &crowd)?;
    Ok([stays[0].leaves.zip(stays[1].comes), stays[1].leaves.zip(stays[0].comes)])
}

/// The ways (exclusion, which) that together close a cycle; the cycle's arcs are verified.
fn clause(problem: &Problem, ways: &[Ways], arcs: &[CycleArc]) -> Result<Vec<(usize, usize)>, String> {
    let mut taken = Vec::new();
    for (i, arc) in arcs.iter().enumerate() {
        if arc.after != arcs[(i + 1) % arcs.len()].before {
            return Err(format!("after {} the cycle is not joined", words(&arc.after)));
        }
        let ends = (named::point(problem, &arc.before)?, named::point(problem, &arc.after)?);
        let holds = match arc.origin {
            CycleOrigin::Robot => of_robot(problem, ends),
            CycleOrigin::Object => of_object(problem, ends) || gates(problem).any(|gate| gate == ends),
            CycleOrigin::Given => of_list(problem, ends) || gates(problem).any(|gate| gate == ends),
            CycleOrigin::Excluded { exclusion } => {
                let index = exclusion as usize;
                let way = ways.get(index).and_then(|ways| ways.iter().position(|way| *way == Some(ends)));
                taken.extend(way.map(|way| (index, way)));
                way.is_some()
            }
        };
        if !holds {
            return Err(format!("{} need not come before {}", words(&arc.before), words(&arc.after)));
        }
    }
    if arcs.is_empty() { Err("a cycle has no arcs".to_owned()) } else { Ok(taken) }
}

fn of_robot(problem: &Problem, (before, after): (At, At)) -> bool {
    let robot = problem.pair(before.0).robot;
    let number = |at: At| problem.pairs_of_robot(robot).position(|pair| pair == at.0).map(|i| (i, at.1));
    match (number(before), number(after)) {
        (Some(before), Some(after)) => before < after,
        _ => false,
    }
}

fn of_list(problem: &Problem, ends: (At, At)) -> bool {
    problem.orderings.iter().any(|given| (given.before, given.after) == ends)
}

fn of_object(problem: &Problem, (before, after): (At, At)) -> bool {
    let hops = problem.hops_of_object(problem.pair(before.0).object);
    hops.windows(2).any(|hops| ((hops[0], model::Point::Release), (hops[1], model::Point::Grasp)) == (before, after))
}

/// Looks for a way for each exclusion such that no clause is taken whole.
struct Orders<'a> {
    ways: &'a [Ways],
    clauses: &'a [Vec<(usize, usize)>],
    /// Which way was taken for the exclusions so far.
    taken: Vec<usize>,
    steps: u64,
}

impl Orders<'_> {
    fn escapes(&mut self) -> bool {
        self.steps += 1;
        let is_taken = |(exclusion, way): &(usize, usize)| self.taken.get(*exclusion) == Some(way);
        if self.clauses.iter().any(|clause| clause.iter().all(is_taken)) {
            return false;
        }
        let Some(ways) = self.ways.get(self.taken.len()) else { return true };
        for way in 0..2 {
            if ways[way].is_some() {
                self.taken.push(way);
                if self.steps >= MOST_STEPS || self.escapes() {
                    return true;
                }
                self.taken.pop();
            }
        }
        false
    }
}
