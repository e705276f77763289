//! The stage: jobs in, candidates out.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Mutex;

use collision::GeometryError;
use contract::{
    Answer, CauseTally, DiscoveredOrder, FailureReport, HopJob, Interrupted, Job, JobContext, MOST_PLACEMENT_SAMPLES,
    Outcome, Placed, PlacementCandidate, PlacementJob, ProblemStatement, Request, SamplesJob, Stage, StageKind,
};
use model::PairId;
use plan::Cause;
use skeleton::Skeleton;

use crate::bits;
use crate::enumeration::{Enumeration, Solved};
use crate::hop::Hop;
use crate::network::Stop;
use crate::nogoods::Nogoods;
use crate::order_sets::{OrderSets, Patience};

use crate::samples::{Paid, Samples};
use crate::verdict::Judge;
use crate::world::World;
use crate::{proof, report};

/// Most candidates of one job.
const MOST_CANDIDATES: u32 = 1 << 16;

/// The placement stage.
pub struct PlacementStage {
    /// Or the given orderings that contradict one another.
    world: Result<World, FailureReport>,
    /// Why there can be no placement, whatever the samples.
    impossible: Option<FailureReport>,
    /// Samples by level.
    drawn: Mutex<BTreeMap<u32, Samples>>,
}

impl PlacementStage {
    /// The stage for one statement.
    ///
    /// # Errors
    /// When a shape of the problem is degenerate.
    pub fn new(statement: &ProblemStatement) -> Result<Self, GeometryError> {
        let problem = &statement.problem;
        let world = match Skeleton::of_problem(problem) {
            Ok(skeleton) => Ok(World::new(statement, &skeleton)?),
            Err(cycle) => Err(proof::cyclic(problem, &cycle)),
        };
        let impossible = match &world {
            Ok(world) => proof::impossible(problem, &world.layout),
            Err(report) => Some(report.clone()),
        };
        Ok(Self { world, impossible, drawn: Mutex::default() })
    }

    fn place(&self, job: &PlacementJob, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let world = match (&self.world, &self.impossible) {
            (Ok(world), None) => world,
            (Err(report), _) | (_, Some(report)) => {
                return Ok(Outcome { result: Err(report.clone()), work: context.spent() });
            }
        };
        let samples = samples_of(world, job.level, job.count)?;
        let mut drawn = self.drawn.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let mut search = Search { world, job, count: samples, found: Vec::new() };
        let end = search.run(&mut drawn, context)?;
        Ok(search.outcome(end, context.spent()))
    }

    /// Choices for one hop. Proofs about all hops together are left out: whoever asks so has not the whole in view.
    fn place_hop(&self, job: &HopJob, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let world = match &self.world {
            Ok(world) => world,
            Err(report) => return Ok(Outcome { result: Err(report.clone()), work: context.spent() }),
        };
        let samples = samples_of(world, job.level, job.count)?;
        match Hop::new(world, job)?.answer(samples, context) {
            Ok(outcome) => Ok(outcome),
            Err(Stop::Interrupted(interrupted)) => Err(interrupted),
            Err(Stop::Budget) => Ok(out_of_budget(job.level, context)),
        }
    }
}

impl PlacementStage {
    /// The samples of one hop that touch nothing that is always there.
    fn samples(&self, job: &SamplesJob, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        let world = match &self.world {
            Ok(world) => world,
            Err(report) => return Ok(Outcome { result: Err(report.clone()), work: context.spent() }),
        };
        let site = world.layout.sites.iter().position(|site| site.placed_by == Some(job.pair));
        let site = site.ok_or_else(|| Interrupted::Unfit(format!("no hop of pair {}", job.pair.0)))?;
        let count = samples_of(world, job.level, 1)?;
        let mut drawn = self.drawn.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        match samples_at(world, &mut drawn, job.level, count, context) {
            Ok(samples) => {
                let poses = samples.poses[site].iter().enumerate();
                let free = poses.filter(|(value, _)| bits::contains(samples.free.row(site), *value));
                let free = free.map(|(value, pose)| (value as u32, *pose)).collect();
                Ok(Outcome::answer(Answer::Samples(free), context.spent()))
            }
            Err(Stop::Interrupted(interrupted)) => Err(interrupted),
            Err(Stop::Budget) => Ok(out_of_budget(job.level, context)),
        }
    }
}

fn out_of_budget(level: u32, context: &JobContext<'_>) -> Outcome {
    let mut causes = CauseTally::default();
    causes.count(Cause::Budget { stage: StageKind::Placement.name().to_owned() });
    Outcome::soft_failure(causes, level, context.spent())
}

/// The samples of a level, drawn if they are not known.
fn samples_at<'a>(
    world: &World,
    drawn: &'a mut BTreeMap<u32, Samples>,
    level: u32,
    count: usize,
    context: &mut JobContext<'_>,
) -> Result<&'a mut Samples, Stop> {
    match drawn.entry(level) {
        Entry::Occupied(known) => {
            known.get().pay_again(context)?;
            Ok(known.into_mut())
        }
        Entry::Vacant(gap) => Ok(gap.insert(Samples::draw(world, count, context)?)),
    }
}

/// Samples of each hop at a level, if it and the number of answers are within bounds.
fn samples_of(world: &World, level: u32, count: u32) -> Result<usize, Interrupted> {
    let samples = u64::from(world.problem().levels.placements).checked_shl(level).unwrap_or(u64::MAX);
    if samples > MOST_PLACEMENT_SAMPLES || level > MOST_PLACEMENT_SAMPLES.ilog2() || count > MOST_CANDIDATES {
        return Err(Interrupted::Unfit(format!("level {level} or {count} candidates are too many")));
    }
    Ok(samples as usize)
}

impl Stage for PlacementStage {
    fn refine(&self, job: &Job, context: &mut JobContext<'_>) -> Result<Outcome, Interrupted> {
        match &job.request {
            Request::Placement(job) => self.place(job, context),
            Request::Hop(job) => self.place_hop(job, context),
            Request::Samples(job) => self.samples(job, context),
            _ => Err(Interrupted::Unfit("not a job of the placement stage".to_owned())),
        }
    }
}

/// Work on one job.
struct Search<'a> {
    world: &'a World,
    job: &'a PlacementJob,
    /// Samples of each hop.
    count: usize,
    found: Vec<PlacementCandidate>,
}

/// How the work on a job ended.
enum End {
    /// All that was asked for is found.
    Enough,
    /// There are no more candidates; this stood in the way of others.
    Exhausted(CauseTally),
    /// The budget was used up; this stood in the way so far.
    Budget(CauseTally),
}

impl Search<'_> {
    /// Fills `found`.
    fn run(&mut self, drawn: &mut BTreeMap<u32, Samples>, context: &mut JobContext<'_>) -> Result<End, Interrupted> {
        let samples = match samples_at(self.world, drawn, self.job.level, self.count, context) {
            Ok(samples) => samples,
            Err(Stop::Budget) => return Ok(End::Budget(CauseTally::default())),
            Err(Stop::Interrupted(interrupted)) => return Err(interrupted),
        };
        let (problem, layout) = (self.world.problem(), &self.world.layout);
        let nogoods = Nogoods::new(&self.job.nogoods, layout, self.count);
        let free = samples.free.clone();
        let mut enumeration =
            Enumeration::new(OrderSets::new(Judge::new(problem, layout, &free, nogoods), Patience::default()));
        let mut paid = Paid::new(self.world, samples, context);
        for index in 0..self.job.first.saturating_add(self.job.count) {
            let solved = match enumeration.next(&mut paid) {
                Ok(Some(solved)) => solved,
                Ok(None) => return Ok(End::Exhausted(enumeration.into_causes(&paid.samples.rejected))),
                Err(Stop::Budget) => return Ok(End::Budget(enumeration.into_causes(&paid.samples.rejected))),
                Err(Stop::Interrupted(interrupted)) => return Err(interrupted),
            };
            if index >= self.job.first {
                self.found.push(candidate(self.world, &paid.samples.poses, index, &solved));
            }
        }
        Ok(End::Enough)
    }

    fn outcome(self, end: End, work: u64) -> Outcome {
        let causes = match end {
            End::Budget(mut causes) => {
                causes.count(Cause::Budget { stage: StageKind::Placement.name().to_owned() });
                Some(causes)
            }
            End::Exhausted(causes) if self.job.first == 0 => Some(causes),
            End::Exhausted(_) | End::Enough => None,
        };
        match causes {
            Some(causes) if self.found.is_empty() => Outcome::soft_failure(causes, self.job.level, work),
            _ => Outcome::answer(Answer::Placements(self.found), work),
        }
    }
}

fn candidate(world: &World, poses: &[Vec<model::Pose>], index: u32, solved: &Solved) -> PlacementCandidate {
    let layout = &world.layout;
    let placed = |pair: PairId| {
        let site = layout.sites.iter().position(|site| site.placed_by == Some(pair))?;
        let sample = solved.values[site];
        Some(Placed { pair, sample: sample as u32, world_from_object: poses[site][sample] })
    };
    let orders = solved.orders.iter().map(|order| &layout.orders[*order]).map(|order| DiscoveredOrder {
        before: order.before,
        after: order.after,
        cause: report::overlap(world.problem(), layout, order),
    });
    let pairs = (0..world.problem().pairs.len()).map(PairId::at);
    PlacementCandidate { index, placements: pairs.filter_map(placed).collect(), orders: orders.collect() }
}
