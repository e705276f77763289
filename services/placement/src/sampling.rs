//! Samples of an object's poses in a region: sample `i` is the same at every level.
//!
//! Sample 0 is the middle of the hop's own slot of a grid over the region, samples 1, 3, 5… those of the other slots in
//! turn; all others are spread by a Halton sequence with a random shift (Cranley and Patterson, SIAM J. Numer. Anal. 13
//! (1976) 904, doi:10.1137/0713071): first the yaw, then x and y in what this yaw leaves of the rectangle.

use contract::{RandomStream, StageKind, halton};
use model::{Pair, Pose, Problem};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use crate::footprint::{FittingYaws, Footprint, Rectangle};
use crate::slots::Slots;

/// Draws poses for one hop.
#[derive(Clone, Debug)]
pub(crate) struct HopSampler {
    footprint: Footprint,
    rectangle: Rectangle,
    yaws: FittingYaws,
    slots: Slots,
    /// The hop's own slot.
    slot: usize,
    world_from_region: Pose,
    /// Height of the object's origin above the surface (m).
    origin_height: f64,
    shift: [f64; 4],
}

impl HopSampler {
    /// The sampler of a pair's object in its region `to`.
    pub fn new(problem: &Problem, seed: u64, pair: &Pair) -> Self {
        let (object, region) = (&problem.movable[pair.object.index()], &problem.regions[pair.to.index()]);
        let footprint = Footprint::of(object);
        let rectangle = Rectangle::new(region, &problem.settings);
        let guests: Vec<&Pair> = problem.pairs.iter().filter(|other| other.to == pair.to).collect();
        let footprints: Vec<Footprint> =
            guests.iter().map(|guest| Footprint::of(&problem.movable[guest.object.index()])).collect();
        let slots = Slots::new(rectangle, &footprints.iter().collect::<Vec<_>>(), problem.settings.clearance);
        let hop = pair.hop.to_string();
        let stream = RandomStream::new(seed, StageKind::Placement, &[&object.name, &region.name, &hop], "pose");
        Self {
            yaws: FittingYaws::new(&footprint, &rectangle),
            slot: guests.iter().position(|guest| *guest == pair).unwrap_or(0),
            world_from_region: region.world_from_region,
            origin_height: object.origin_height(),
            shift: stream.unit(0),
            footprint,
            rectangle,
            slots,
        }
    }

    /// Pose number `index`; `None` if the object fits the region at no yaw that was tried.
    pub fn world_from_object(&self, index: usize) -> Option<Pose> {
        let in_slot = self.slot_of(index).and_then(|slot| self.middle_of(slot));
        let ([x, y], yaw) = in_slot.or_else(|| self.spread(index))?;
        let region_from_object = Pose::from_parts(
            Translation3::new(x, y, self.origin_height),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw),
        );
        Some(self.world_from_region * region_from_object)
    }

    fn slot_of(&self, index: usize) -> Option<usize> {
        let turn = index.div_ceil(2);
        let in_turn = (index == 0 || index % 2 == 1) && turn < self.slots.count();
        in_turn.then_some(self.slot + turn)
    }

    /// As near to a slot's middle as the region allows, turned so that most of the slot is left over.
    fn middle_of(&self, slot: usize) -> Option<([f64; 2], f64)> {
        let spare = |yaw: f64| {
            let ([x, y], cell) = (self.footprint.extent(yaw), self.slots.cell());
            (cell[0] - x).min(cell[1] - y)
        };
        let fitting = self.yaws.quarters.iter().copied();
        let yaw = fitting.reduce(|best, next| if spare(next) > spare(best) + 1e-9 { next } else { best })?;
        let (least, greatest) = self.footprint.bounds(yaw);
        let middle = self.slots.middle(slot);
        let centred = std::array::from_fn(|i| middle[i] - (least[i] + greatest[i]) / 2.0);
        Some((self.footprint.room(&self.rectangle, yaw)?.nearest(centred), yaw))
    }

    fn spread(&self, index: usize) -> Option<([f64; 2], f64)> {
        let shifted = |dimension: usize, base| (halton(index as u64, base) + self.shift[dimension]).fract();
        let [x, y, turn, kind] = [shifted(0, 2), shifted(1, 3), shifted(2, 5), shifted(3, 7)];
        let quarter = || self.yaws.quarter(turn);
        let any = || self.yaws.any(turn, &self.footprint, &self.rectangle);
        let yaw = if kind < 0.5 { quarter().or_else(any) } else { any().or_else(quarter) }?;
        Some((self.footprint.room(&self.rectangle, yaw)?.at([x, y]), yaw))
    }
}
