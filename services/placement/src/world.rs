//! The problem as the stage sees it: geometry, sites, samplers, and the box that each site's body stays in.

use collision::{Geometry, GeometryError, Standing};
use contract::ProblemStatement;
use model::{FixedId, MovableObject, ObjectId, Pose, Problem};
use nalgebra::Point3;
use skeleton::Skeleton;

use crate::layout::{Layout, Site};
use crate::sampling::HopSampler;

/// Everything that does not depend on the level.
#[derive(Debug)]
pub(crate) struct World {
    pub geometry: Geometry,
    pub layout: Layout,
    /// For each site, how its pose is drawn; a start pose is given.
    pub samplers: Vec<Option<HopSampler>>,
    /// Objects that never leave their start pose.
    pub resting: Vec<Standing>,
    /// For each site, a bound on the horizontal distance of the body's points from its origin (m).
    pub reach_m: Vec<f64>,
}

impl World {
    /// The world of a statement.
    ///
    /// # Errors
    /// When a shape of the problem is degenerate.
    pub fn new(statement: &ProblemStatement, skeleton: &Skeleton) -> Result<Self, GeometryError> {
        let problem = &statement.problem;
        let geometry = Geometry::new(problem)?;
        let boxes: Vec<[Point3<f64>; 2]> =
            skeleton.occupancies().map(|occupancy| bounds(problem, skeleton, occupancy)).collect();
        let clearance = problem.settings.clearance;
        let layout = Layout::new(problem, skeleton, |a, b| near(&boxes[a], &boxes[b], clearance));
        let sampler = |site: &Site| {
            let pair = problem.pair(site.placed_by?);
            Some(HopSampler::new(problem, statement.seed, pair))
        };
        let resting = (0..problem.movable.len()).filter(|object| skeleton.hops[*object].is_empty());
        Ok(Self {
            samplers: layout.sites.iter().map(sampler).collect(),
            resting: resting.map(|object| start(problem, ObjectId::at(object))).collect(),
            reach_m: layout.sites.iter().map(|site| reach(problem, site)).collect(),
            layout,
            geometry,
        })
    }

    /// The problem.
    pub fn problem(&self) -> &Problem {
        self.geometry.problem()
    }

    /// What a site's object stands on; none for a start pose.
    pub fn support(&self, site: usize) -> Option<FixedId> {
        let region = self.layout.sites[site].region(self.problem())?;
        Some(self.problem().regions[region.index()].support)
    }
}

/// An object where it stands at the start.
pub(crate) fn start(problem: &Problem, object: ObjectId) -> Standing {
    Standing { object, world_from_object: problem.movable[object.index()].world_from_start }
}

fn reach(problem: &Problem, site: &Site) -> f64 {
    let object = &problem.movable[site.object().index()];
    let turn = if site.placed_by.is_some() { Pose::identity() } else { object.world_from_start };
    let points = body_points(object).into_iter().map(|p| turn.rotation * p.coords);
    points.fold(0.0, |far: f64, p| far.max(p.x.hypot(p.y))) + object.body.shape.rounding()
}

fn body_points(object: &MovableObject) -> Vec<Point3<f64>> {
    object.body.shape.support_points().iter().map(|p| object.body.owner_from_shape * p).collect()
}

/// Least and greatest corner (m) of a box that the body stays in: at a hop's end all over its region.
fn bounds(problem: &Problem, skeleton: &Skeleton, occupancy: skeleton::Occupancy) -> [Point3<f64>; 2] {
    let object = &problem.movable[occupancy.object.index()];
    let rounding = object.body.shape.rounding();
    let Some(hop) = occupancy.hop.checked_sub(1) else {
        let points = body_points(object).into_iter().map(|p| object.world_from_start * p);
        return around(points, rounding);
    };
    let pair = problem.pair(skeleton.hops[occupancy.object.index()][hop as usize]);
    let region = &problem.regions[pair.to.index()];
    let points = body_points(object);
    let lowest = points.iter().fold(f64::MAX, |least, p| least.min(p.z));
    let height = points.iter().fold(0.0, |most: f64, p| most.max(p.z - lowest)) + 2.0 * rounding;
    let [x, y] = region.size.map(|edge| edge / 2.0);
    let corners = (0..8).map(|i| {
        let side = |bit: i32, half: f64| if i >> bit & 1 == 1 { half } else { -half };
        let z = if i >> 2 & 1 == 1 { height } else { 0.0 };
        region.world_from_region * Point3::new(side(0, x), side(1, y), z)
    });
    around(corners, 0.0)
}

fn around(points: impl Iterator<Item = Point3<f64>>, margin: f64) -> [Point3<f64>; 2] {
    let whole = points
        .fold([Point3::from([f64::MAX; 3]), Point3::from([f64::MIN; 3])], |[low, high], p| [low.inf(&p), high.sup(&p)]);
    let margin = nalgebra::Vector3::repeat(margin);
    [whole[0] - margin, whole[1] + margin]
}

fn near(a: &[Point3<f64>; 2], b: &[Point3<f64>; 2], clearance: f64) -> bool {
    (0..3).all(|i| a[0][i] - clearance <= b[1][i] && b[0][i] - clearance <= a[1][i])
}
