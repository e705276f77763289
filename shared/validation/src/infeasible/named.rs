//! What the names of a certificate mean.

use model::{FixedId, ObjectId, Pair, PairId, Point, Problem, RegionId, RobotId};
use plan::{PairEnd, PairPoint, Stay};

use crate::irredundant::leaving;
use crate::precedence::At;

/// Finds the entry with this name.
fn find<T>(list: &[T], name: &str, what: &str, name_of: impl Fn(&T) -> &str) -> Result<usize, String> {
    list.iter().position(|entry| name_of(entry) == name).ok_or_else(|| format!("there is no {what} `{name}`"))
}

pub(crate) fn robot(problem: &Problem, name: &str) -> Result<RobotId, String> {
    find(&problem.robots, name, "robot", |robot| &robot.name).map(RobotId::at)
}

pub(crate) fn region(problem: &Problem, name: &str) -> Result<RegionId, String> {
    find(&problem.regions, name, "region", |region| &region.name).map(RegionId::at)
}

pub(crate) fn object(problem: &Problem, name: &str) -> Result<ObjectId, String> {
    find(&problem.movable, name, "movable object", |object| &object.name).map(ObjectId::at)
}

pub(crate) fn fixed(problem: &Problem, name: &str) -> Result<FixedId, String> {
    find(&problem.fixed, name, "fixed object", |fixed| &fixed.name).map(FixedId::at)
}

pub(crate) fn pair(problem: &Problem, name: &str) -> Result<PairId, String> {
    find(&problem.pairs, name, "pair", |pair| &pair.name).map(PairId::at)
}

pub(crate) fn point(problem: &Problem, at: &PairPoint) -> Result<At, String> {
    Ok((pair(problem, &at.pair)?, at.point))
}

/// One end of a pair, as a certificate names it.
#[derive(Clone, Copy)]
pub(crate) struct PairAt<'a> {
    pub(crate) pair: &'a Pair,
    pub(crate) end: PairEnd,
    pub(crate) region: RegionId,
}

impl<'a> PairAt<'a> {
    /// The end of a pair of this robot.
    pub(crate) fn of(problem: &'a Problem, robot_name: &str, pair_name: &str, end: PairEnd) -> Result<Self, String> {
        let pair = problem.pair(pair(problem, pair_name)?);
        if robot(problem, robot_name)? != pair.robot {
            return Err(format!("{pair_name} is no pair of {robot_name}"));
        }
        Ok(Self { pair, end, region: if end == PairEnd::Pick { pair.from } else { pair.to } })
    }

    /// As [`PairAt::of`], with the region it should be in.
    pub(crate) fn in_region(
        problem: &'a Problem,
        robot_name: &str,
        pair_name: &str,
        end: PairEnd,
        region_name: &str,
    ) -> Result<Self, String> {
        let at = Self::of(problem, robot_name, pair_name, end)?;
        if region(problem, region_name)? != at.region {
            return Err(format!("{pair_name} does not end there in {region_name}"));
        }
        Ok(at)
    }
}

/// A stay with its names resolved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Occupation {
    pub(crate) object: ObjectId,
    /// The pair that put the object there.
    pub(crate) placed_by: Option<PairId>,
    /// When it begins; none: at the start.
    pub(crate) comes: Option<At>,
    /// When it leaves its place to others; none: never.
    pub(crate) leaves: Option<At>,
}

impl Occupation {
    pub(crate) fn of(problem: &Problem, stay: &Stay) -> Result<Self, String> {
        let object = object(problem, &stay.object)?;
        let hops = problem.hops_of_object(object);
        let placed_by = stay.placed_by.as_deref().map(|name| pair(problem, name)).transpose()?;
        let next = match placed_by {
            None => 0,
            Some(pair) => {
                let hop = hops.iter().position(|hop| *hop == pair);
                1 + hop.ok_or_else(|| format!("{} does not move {}", problem.pair(pair).name, stay.object))?
            }
        };
        let comes = placed_by.map(|pair| (pair, Point::Release));
        Ok(Self { object, placed_by, comes, leaves: hops.get(next).map(|pair| (*pair, leaving(problem))) })
    }
}
