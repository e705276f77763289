//! Whether something is in the way at every pose that an object may have: poses are covered with cells, and in each cell
//! one body is deeper in a fixed one than it can move within the cell.

use glamx::DVec3;
use model::{FixedId, Grasp, Problem, Robot};

use crate::contact::UPRIGHT;
use crate::frame::Frame;
use crate::infeasible::named::PairAt;
use crate::infeasible::targets::{Patch, Poses, hand_slack};
use crate::infeasible::wedge::Wedge;
use crate::mechanism::Mechanism;
use crate::solid::Solid;

/// Most cells looked at.
const MOST_CELLS: u32 = 400_000;
/// Yaws at which the cover begins.
const YAWS: usize = 8;
/// Allowance (m) for what rule V7 lets a footprint stick out.
const ROUNDING: f64 = 1e-6;

/// A body that moves with the object.
struct Rider {
    /// In the object's frame.
    wedge: Wedge,
    /// How far its points may be off although the checker accepts (m).
    slack: f64,
}

/// What is in whose way.
struct Cover<'a> {
    riders: Vec<Rider>,
    fixed: Vec<Wedge>,
    object: &'a Solid,
}

/// Poses of the object in a region: its origin in a rectangle about `u`, `v` (m, along the region's edges), its yaw about
/// `yaw` (rad, against the region).
#[derive(Clone, Copy)]
struct Cell {
    middle: [f64; 3],
    half: [f64; 3],
}

/// At every pose of this end of the pair, the hand under this grasp, or the object, is in one of these fixed objects.
pub(crate) fn check_blocked(problem: &Problem, at: &PairAt, grasp: &Grasp, by: &[FixedId]) -> Result<(), String> {
    let robot = problem.robot(at.pair.robot);
    let object = Solid::new(&problem.movable[at.pair.object.index()].body);
    let fixed = by.iter().flat_map(|id| {
        let fixed = &problem.fixed[id.index()];
        let frame = Frame::of(&fixed.world_from_object);
        fixed.bodies.iter().map(move |body| Wedge::of(body).placed(&frame))
    });
    let mut cover = Cover { riders: hand(robot, grasp)?, fixed: fixed.collect(), object: &object };
    match Poses::of(problem, at)? {
        Poses::Start(frame) => {
            let blocked = cover.blocks(&frame, [0.0; 3]);
            blocked.then_some(()).ok_or_else(|| "the hand has room at the start pose".to_owned())
        }
        Poses::Within(patch) => {
            let tolerance = problem.settings.support_tolerance;
            cover.riders.iter_mut().for_each(|rider| rider.slack += tolerance);
            let wedge = Wedge::of(&problem.movable[at.pair.object.index()].body);
            // What it stands on may be overlapped by the tolerance; it may stand that much lower, and lean.
            let slack = 2.0 * tolerance + UPRIGHT * wedge.reach + ROUNDING;
            cover.riders.push(Rider { wedge, slack });
            cover.check(&patch)
        }
    }
}

/// Everything that rides with the hand, open and at the grasp's opening: before an attach and after a release the hand is
/// open at the very place where it holds the object.
fn hand(robot: &Robot, grasp: &Grasp) -> Result<Vec<Rider>, String> {
    let mechanism = Mechanism::new(robot).ok_or_else(|| format!("the joints of {} are no tree", robot.name))?;
    let object_from_hand = Frame::of(&grasp.link_from_object).inverse();
    let mut riders = Vec::new();
    for opening in [robot.end_effector.max_opening, grasp.opening] {
        for (link, hand_from_link) in mechanism.riding_with(robot, robot.end_effector.parent_link, opening) {
            let object_from_link = object_from_hand * hand_from_link;
            let wedges = robot.links[link.index()].bodies.iter().map(Wedge::of);
            riders.extend(wedges.map(|wedge| {
                let wedge = wedge.placed(&object_from_link);
                Rider { slack: hand_slack(wedge.reach), wedge }
            }));
        }
    }
    Ok(riders)
}

impl Cover<'_> {
    /// Whether one body is in a fixed object for all poses within a cell about `frame`; `half` are the cell's half edges.
    fn blocks(&self, frame: &Frame, half: [f64; 3]) -> bool {
        self.riders.iter().any(|rider| {
            let moves = half[0].hypot(half[1]) + half[2] * rider.wedge.swing + rider.slack;
            let placed = rider.wedge.placed(frame);
            self.fixed.iter().any(|fixed| placed.depth(fixed) > moves)
        })
    }

    fn check(&self, patch: &Patch) -> Result<(), String> {
        let part = std::f64::consts::PI / YAWS as f64;
        let [u, v] = patch.half.to_array();
        let first = |i: usize| Cell { middle: [0.0, 0.0, part * (2 * i) as f64], half: [u, v, part] };
        let mut open: Vec<Cell> = (0..YAWS).map(first).collect();
        let swing = self.riders.iter().map(|rider| rider.wedge.swing).fold(0.0, f64::max);
        let mut looked_at = 0;
        while let Some(cell) = open.pop() {
            looked_at += 1;
            let frame = cell.frame(patch);
            if self.is_outside(patch, &cell) || self.blocks(&frame, cell.half) {
                continue;
            }
            if looked_at > MOST_CELLS || !self.blocks(&frame, [0.0; 3]) && !self.is_outside(patch, &cell.point()) {
                let [x, y, _] = frame.origin.to_array();
                return Err(format!("it has room at {x:.4}, {y:.4} m, as far as can be told"));
            }
            open.extend(cell.split(swing));
        }
        Ok(())
    }

    /// Whether the object sticks out of the region at every pose of a cell.
    fn is_outside(&self, patch: &Patch, cell: &Cell) -> bool {
        let turned = Frame::turned(DVec3::Z, cell.middle[2]) * self.object.owner_from_shape;
        let slack = cell.half[2] * (self.object.centre.length() + self.object.radius) + ROUNDING;
        [(0, DVec3::X, patch.rectangle.half.x), (1, DVec3::Y, patch.rectangle.half.y)].into_iter().any(
            |(i, axis, free)| {
                let (ahead, behind) =
                    (self.object.height_along(&turned, axis), self.object.height_along(&turned, -axis));
                let (least, greatest) = (cell.middle[i] - cell.half[i], cell.middle[i] + cell.half[i]);
                least + ahead - slack > free || behind - greatest - slack > free
            },
        )
    }
}

impl Cell {
    /// The middle pose in the world.
    fn frame(&self, patch: &Patch) -> Frame {
        let [u, v, yaw] = self.middle;
        let region = &patch.rectangle.world_from_region;
        let mut frame = *region * Frame::shifted(DVec3::new(u, v, 0.0)) * Frame::turned(DVec3::Z, yaw);
        frame.origin.z = patch.height;
        frame
    }

    fn point(&self) -> Self {
        Self { middle: self.middle, half: [0.0; 3] }
    }

    /// Halves, across where they move a point at distance `swing` the most.
    fn split(&self, swing: f64) -> [Self; 2] {
        let moves = [self.half[0], self.half[1], self.half[2] * swing.max(ROUNDING)];
        let axis = (0..3).fold(0, |most, axis| if moves[axis] > moves[most] { axis } else { most });
        [-0.5, 0.5].map(|side| {
            let mut half = *self;
            half.half[axis] /= 2.0;
            half.middle[axis] += side * self.half[axis];
            half
        })
    }
}
