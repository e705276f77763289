//! The samples of one level: poses of every site, which of them are free, and which of them collide.

use collision::{Contact, Standing};
use contract::{CauseTally, JobContext};
use model::Pose;
use plan::{BodyRef, Cause};

use crate::bits::{self, BitRows};
use crate::network::{Overlaps, Stop};
use crate::report;
use crate::world::World;

/// Poses of one level. What is known of their collisions grows as it is asked for, and is kept from job to job.
#[derive(Debug)]
pub(crate) struct Samples {
    /// Poses of each site; a start pose is the only one of its site.
    pub poses: Vec<Vec<Pose>>,
    /// Samples that touch neither fixed objects nor objects that never move.
    pub free: BitRows,
    /// What the others touch, for each site.
    pub rejected: Vec<CauseTally>,
    /// Work units that the tests of single poses cost.
    work: u64,
    /// `collisions[site][neighbour][value]`: values of that neighbour, once asked for.
    collisions: Vec<Vec<Vec<Row>>>,
}

/// A set of values; unknown at first.
type Row = Option<Box<[u64]>>;

impl Samples {
    /// Draws `count` poses for each hop and tests each alone. Pays before every test, so that it can be broken off.
    pub fn draw(world: &World, count: usize, context: &mut JobContext<'_>) -> Result<Self, Stop> {
        let before = context.spent();
        let draw = |site: usize| match world.given_pose(site) {
            None => (0..count).map_while(|index| world.sample(site, index)).collect(),
            Some(start) => vec![start],
        };
        let poses: Vec<Vec<Pose>> = (0..world.samplers.len()).map(draw).collect();
        let most = poses.iter().map(Vec::len).max().unwrap_or(0);
        let mut free = BitRows::new(poses.len(), most);
        let mut rejected = vec![CauseTally::default(); poses.len()];
        for (site, poses) in poses.iter().enumerate() {
            for (value, pose) in poses.iter().enumerate() {
                pay(context, 1)?;
                match world.obstruction(site, pose) {
                    None => bits::insert(free.row_mut(site), value),
                    Some(cause) => rejected[site].count(cause),
                }
            }
        }
        let of_site = |site: usize| vec![vec![None; poses[site].len()]; world.layout.neighbours[site].len()];
        let collisions = (0..poses.len()).map(of_site).collect();
        Ok(Self { poses, free, rejected, work: context.spent() - before, collisions })
    }

    /// Pays for what an earlier job has drawn, unit by unit as that one did.
    pub fn pay_again(&self, context: &mut JobContext<'_>) -> Result<(), Stop> {
        (0..self.work).try_for_each(|_| pay(context, 1))
    }
}

impl World {
    /// The pose of a site that is nobody's choice: a start pose.
    pub fn given_pose(&self, site: usize) -> Option<Pose> {
        let object = self.layout.sites[site].object();
        self.samplers[site].is_none().then(|| self.problem().movable[object.index()].world_from_start)
    }

    /// Pose number `index` of a hop; `None` if its object fits the region at no yaw that was tried, or there is no choice.
    pub fn sample(&self, site: usize, index: usize) -> Option<Pose> {
        self.samplers[site].as_ref()?.world_from_object(index)
    }

    /// Whether the bodies at two sites collide.
    pub fn poses_collide(&self, first: (usize, &Pose), second: (usize, &Pose)) -> bool {
        let standing = |(site, pose): (usize, &Pose)| Standing {
            object: self.layout.sites[site].object(),
            world_from_object: *pose,
        };
        let far = self.reach_m[first.0] + self.reach_m[second.0] + self.problem().settings.clearance;
        let apart = (second.1.translation.vector - first.1.translation.vector).xy().norm();
        apart <= far && self.geometry.standings_collide(&standing(first), &standing(second))
    }

    /// What a pose of a hop touches that is always there.
    pub fn obstruction(&self, site: usize, world_from_object: &Pose) -> Option<Cause> {
        let support = self.support(site)?;
        let standing = Standing { object: self.layout.sites[site].object(), world_from_object: *world_from_object };
        let first = report::object(self.problem(), &self.layout.sites[site]);
        if let Some(Contact { second, .. }) = self.geometry.standing_contact(&standing, Some(support)) {
            return Some(Cause::Collision { first, second: BodyRef::Fixed(self.fixed_name(second)) });
        }
        let resting = self.resting.iter().find(|resting| self.geometry.standings_collide(&standing, resting))?;
        let second = BodyRef::Object(self.problem().movable[resting.object.index()].name.clone());
        Some(Cause::Collision { first, second })
    }

    fn fixed_name(&self, body: collision::BodyName) -> String {
        match body {
            collision::BodyName::Fixed(fixed) => self.problem().fixed[fixed.index()].name.clone(),
            other => other.describe(self.problem()),
        }
    }
}

/// The samples of a level during one job. A job pays for every row that it reads first, whether it was known or not:
/// what a job costs does not depend on what was asked before it.
pub(crate) struct Paid<'a, 'b> {
    world: &'a World,
    pub samples: &'a mut Samples,
    context: &'a mut JobContext<'b>,
    /// `paid[site][neighbour]`: values whose rows this job has paid for.
    paid: Vec<Vec<Vec<u64>>>,
}

impl<'a, 'b> Paid<'a, 'b> {
    pub fn new(world: &'a World, samples: &'a mut Samples, context: &'a mut JobContext<'b>) -> Self {
        let of_site = |site: usize| vec![Vec::new(); world.layout.neighbours[site].len()];
        let paid = (0..samples.poses.len()).map(of_site).collect();
        Self { world, samples, context, paid }
    }
}

impl Overlaps for Paid<'_, '_> {
    fn row(&mut self, first: usize, value: usize, second: usize) -> Result<&[u64], Stop> {
        let position = self.world.layout.neighbours[first].partition_point(|other| *other < second);
        let paid = &mut self.paid[first][position];
        if paid.is_empty() {
            paid.resize(bits::words_for(self.samples.poses[first].len()), 0);
        }
        if !bits::contains(paid, value) {
            bits::insert(paid, value);
            pay(self.context, u64::from(bits::count(self.samples.free.row(second))))?;
        }
        let Samples { poses, free, collisions, .. } = &mut *self.samples;
        let row = &mut collisions[first][position][value];
        Ok(row.get_or_insert_with(|| collide(self.world, poses, free, (first, value), second)))
    }

    fn spend(&mut self, units: u64) -> Result<(), Stop> {
        pay(self.context, units)
    }
}

fn collide(
    world: &World,
    poses: &[Vec<Pose>],
    free: &BitRows,
    (first, value): (usize, usize),
    second: usize,
) -> Box<[u64]> {
    let mut row = vec![0; free.row(second).len()];
    for other in bits::indices(free.row(second)) {
        if world.poses_collide((first, &poses[first][value]), (second, &poses[second][other])) {
            bits::insert(&mut row, other);
        }
    }
    row.into_boxed_slice()
}

/// Pays for work on a job.
pub(crate) fn pay(context: &mut JobContext<'_>, units: u64) -> Result<(), Stop> {
    match context.spend(units) {
        Ok(true) => Ok(()),
        Ok(false) => Err(Stop::Budget),
        Err(interrupted) => Err(Stop::Interrupted(interrupted)),
    }
}
