//! Choices for one hop, given the places of others: for searches that place hop by hop.
//!
//! Samples, obstacles and orders are those of whole candidates. A sample that collides with what may be there at the same
//! time comes once for every way to order its collisions that closes no cycle.

use contract::{Answer, CauseTally, DiscoveredOrder, HopChoice, HopJob, Interrupted, JobContext, Outcome, Placed};
use model::Pose;
use skeleton::{ArcOrigin, EventGraph};

use crate::layout::{Layout, Order};
use crate::network::Stop;
use crate::report;
use crate::samples::pay;
use crate::world::World;

/// A hop among what is placed.
pub(crate) struct Hop<'a> {
    world: &'a World,
    job: &'a HopJob,
    site: usize,
    /// Sites that could be in its way, ascending, with the poses there.
    others: Vec<(usize, Pose)>,
    /// The given order with the job's.
    graph: EventGraph,
    causes: CauseTally,
}

impl<'a> Hop<'a> {
    /// The hop of a job.
    ///
    /// # Errors
    /// [`Interrupted::Unfit`] if the job names what the problem does not have, or orders that contradict it.
    pub fn new(world: &'a World, job: &'a HopJob) -> Result<Self, Interrupted> {
        let unfit = |why: &str| Interrupted::Unfit(why.to_owned());
        let layout = &world.layout;
        let site_of = |pair| layout.sites.iter().position(|site| site.placed_by == Some(pair));
        let site = site_of(job.pair).ok_or_else(|| unfit("no such pair"))?;
        let mut poses: Vec<Option<Pose>> = (0..layout.sites.len()).map(|site| world.given_pose(site)).collect();
        for placed in &job.placed {
            let at = site_of(placed.pair).ok_or_else(|| unfit("no such pair"))?;
            if at == site || poses[at].replace(placed.world_from_object).is_some() {
                return Err(unfit("a hop is placed twice"));
            }
        }
        let mut graph = layout.graph.clone();
        for (before, after) in &job.orders {
            let known = layout.has_event(*before) && layout.has_event(*after);
            if !known || graph.add(*before, *after, ArcOrigin::Discovered).is_err() {
                return Err(unfit("orderings that contradict the problem"));
            }
        }
        let neighbours = layout.neighbours[site].iter();
        let others = neighbours.filter_map(|other| Some((*other, poses[*other]?))).collect();
        Ok(Self { world, job, site, others, graph, causes: CauseTally::default() })
    }

    /// The answer from `count` samples.
    pub fn answer(mut self, count: usize, context: &mut JobContext<'_>) -> Result<Outcome, Stop> {
        let (mut choices, mut against) = (Vec::new(), vec![false; self.others.len()]);
        for sample in 0..count {
            let Some(pose) = self.world.sample(self.site, sample) else { break };
            pay(context, 1)?;
            if let Some(cause) = self.world.obstruction(self.site, &pose) {
                self.causes.count(cause);
                continue;
            }
            let colliding = self.colliding(&pose, context)?;
            colliding.iter().for_each(|other| against[*other] = true);
            let placed = Placed { pair: self.job.pair, sample: sample as u32, world_from_object: pose };
            let sets = self.order_sets(&colliding, context)?;
            choices.extend(sets.into_iter().map(|orders| HopChoice { placed, orders: self.discovered(&orders) }));
        }
        if choices.is_empty() {
            let unplaced = report::no_placement(self.problem(), &self.layout().sites[self.site]);
            unplaced.into_iter().for_each(|cause| self.causes.count(cause));
        }
        choices.sort_by(|a: &HopChoice, b: &HopChoice| {
            let key = |choice: &HopChoice| (choice.orders.len(), choice.placed.sample);
            key(a).cmp(&key(b)).then_with(|| a.orders.cmp(&b.orders))
        });
        let first = self.job.first as usize;
        let choices = choices.into_iter().skip(first).take(self.job.count as usize).collect();
        let hit = self.others.iter().zip(against).filter(|(_, hit)| *hit);
        let against = hit.map(|((site, _), _)| self.layout().sites[*site].occupancy).collect();
        Ok(Outcome::answer(Answer::Hop { choices, against, causes: self.causes.ranked() }, context.spent()))
    }

    fn problem(&self) -> &'a model::Problem {
        self.world.problem()
    }

    fn layout(&self) -> &'a Layout {
        &self.world.layout
    }

    /// Of the others those that a pose collides with, whenever they are there.
    fn colliding(&self, pose: &Pose, context: &mut JobContext<'_>) -> Result<Vec<usize>, Stop> {
        let mut colliding = Vec::new();
        for (index, (other, there)) in self.others.iter().enumerate() {
            pay(context, 1)?;
            if self.world.poses_collide((self.site, pose), (*other, there)) {
                colliding.push(index);
            }
        }
        Ok(colliding)
    }

    /// All ways to order the collisions of one pose, each with the orders that it adds.
    fn order_sets(&mut self, colliding: &[usize], context: &mut JobContext<'_>) -> Result<Vec<Vec<Order>>, Stop> {
        let (mut sets, mut orders) = (Vec::new(), Vec::new());
        self.orient(colliding, &mut orders, &mut sets, context)?;
        Ok(sets)
    }

    fn orient(
        &mut self,
        colliding: &[usize],
        orders: &mut Vec<Order>,
        sets: &mut Vec<Vec<Order>>,
        context: &mut JobContext<'_>,
    ) -> Result<(), Stop> {
        let Some((index, rest)) = colliding.split_first() else {
            sets.push(orders.clone());
            return Ok(());
        };
        let (site, other) = (self.site, self.others[*index].0);
        if !self.layout().may_coexist(&self.graph, site, other) {
            return self.orient(rest, orders, sets, context);
        }
        for (first, second) in [(other, site), (site, other)] {
            let Some((before, after)) = self.layout().order_events(first, second) else { continue };
            pay(context, 1)?;
            let checkpoint = self.graph.checkpoint();
            if let Err(cycle) = self.graph.add(before, after, ArcOrigin::Discovered) {
                self.causes.count(report::cycle(self.problem(), &cycle));
                continue;
            }
            orders.push(Order { first, second, before, after });
            self.orient(rest, orders, sets, context)?;
            orders.pop();
            self.graph.undo(checkpoint);
        }
        // Whether or not an order keeps them apart: without the collision there would be none.
        self.causes.count(report::collision(self.problem(), self.layout(), site, other));
        Ok(())
    }

    fn discovered(&self, orders: &[Order]) -> Vec<DiscoveredOrder> {
        let discovered = |order: &Order| DiscoveredOrder {
            before: order.before,
            after: order.after,
            cause: report::overlap(self.problem(), self.layout(), order),
        };
        orders.iter().map(discovered).collect()
    }
}
