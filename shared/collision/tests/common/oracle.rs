//! Distances by parry's own shapes and dispatcher, poses by forward kinematics, pairs by the rules as said in words.

use collision::{BodyName, Holding, Standing};
use model::{FixedId, LinkId, Pose, Problem, RobotId, Shape};
use parry3d_f64::math::{Pose as ParryPose, Vector};
use parry3d_f64::query::{self, ClosestPoints};
use parry3d_f64::shape::SharedShape;

/// One convex body in the world.
pub struct Piece {
    pub name: BodyName,
    pub shape: SharedShape,
    pub pose: Pose,
}

pub struct Oracle<'a>(pub &'a Problem);

fn parry_shape(shape: &Shape) -> SharedShape {
    match shape {
        Shape::Box { size: [x, y, z] } => SharedShape::cuboid(x / 2.0, y / 2.0, z / 2.0),
        Shape::Sphere { radius } => SharedShape::ball(*radius),
        Shape::Capsule { radius, length } => SharedShape::capsule_z(length / 2.0, *radius),
        // parry's cylinder stands on y; here the axis is z.
        Shape::Cylinder { radius, length } => SharedShape::cylinder(length / 2.0, *radius),
        Shape::Hull { points } => {
            let points: Vec<Vector> = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
            SharedShape::convex_hull(&points).unwrap()
        }
    }
}

fn parry_pose(shape: &Shape, pose: Pose) -> Pose {
    if matches!(shape, Shape::Cylinder { .. }) { pose * super::tilt(std::f64::consts::FRAC_PI_2) } else { pose }
}

impl Piece {
    fn new(name: BodyName, shape: &Shape, pose: Pose) -> Self {
        Self { name, shape: parry_shape(shape), pose: parry_pose(shape, pose) }
    }

    /// Distance (m), 0 when they meet.
    ///
    /// From closest points: parry 0.31.1's `distance` of two cuboids projects twice and stops, and has been seen to
    /// answer 18 mm for 1.6 mm, depending on which is asked first.
    pub fn distance(&self, other: &Piece) -> f64 {
        let (a, b) = (ParryPose::from(self.pose), ParryPose::from(other.pose));
        match query::closest_points(&a, &*self.shape.0, &b, &*other.shape.0, 1e6).unwrap() {
            ClosestPoints::Intersecting => 0.0,
            ClosestPoints::WithinMargin(p, q) => (q - p).length(),
            ClosestPoints::Disjoint => f64::MAX,
        }
    }
}

impl Oracle<'_> {
    pub fn robot(&self, robot: RobotId, holding: Option<Holding>, q: &[f64]) -> Vec<Piece> {
        let noun = self.0.robot(robot);
        let grasp = holding.map(|h| self.0.movable[h.object.index()].grasp(robot, h.grasp));
        let opening = grasp.map_or(noun.end_effector.max_opening, |grasp| grasp.opening);
        let poses = kinematics::link_poses(noun, q, opening);
        let mut pieces = Vec::new();
        for (i, link) in noun.links.iter().enumerate() {
            let name = BodyName::Link { robot, link: LinkId::at(i) };
            pieces.extend(link.bodies.iter().map(|b| Piece::new(name, &b.shape, poses[i] * b.owner_from_shape)));
        }
        if let (Some(holding), Some(grasp)) = (holding, grasp) {
            let name = BodyName::Held { robot, object: holding.object };
            let body = &self.0.movable[holding.object.index()].body;
            let hand = poses[noun.end_effector.parent_link.index()];
            pieces.push(Piece::new(name, &body.shape, hand * grasp.link_from_object * body.owner_from_shape));
        }
        pieces
    }

    pub fn fixed(&self) -> Vec<Piece> {
        let objects = self.0.fixed.iter().enumerate();
        objects
            .flat_map(|(i, object)| {
                let name = BodyName::Fixed(FixedId::at(i));
                let place =
                    move |b: &model::Body| Piece::new(name, &b.shape, object.world_from_object * b.owner_from_shape);
                object.bodies.iter().map(place)
            })
            .collect()
    }

    pub fn standing(&self, standing: &Standing) -> Piece {
        let body = &self.0.movable[standing.object.index()].body;
        Piece::new(BodyName::Object(standing.object), &body.shape, standing.world_from_object * body.owner_from_shape)
    }

    fn may_meet(&self, a: &BodyName, b: &BodyName) -> bool {
        match (a, b) {
            (BodyName::Link { robot, link: first }, BodyName::Link { link: second, .. }) => {
                let pair = (*first.min(second), *first.max(second));
                first == second || self.0.robot(*robot).disabled_pairs.contains(&pair)
            }
            (BodyName::Link { robot, link }, BodyName::Held { .. }) => {
                self.0.robot(*robot).end_effector.links.contains(link)
            }
            _ => false,
        }
    }

    /// Least distance (m) of a robot and its load from itself and the fixed objects, no contact allowed but those that
    /// always are.
    pub fn own_and_fixed(&self, robot: RobotId, holding: Option<Holding>, q: &[f64]) -> f64 {
        let pieces = self.robot(robot, holding, q);
        let mut least = least_distance(&pieces, &self.fixed());
        for (i, first) in pieces.iter().enumerate() {
            for second in &pieces[i + 1..] {
                if !self.may_meet(&first.name, &second.name) {
                    least = least.min(first.distance(second));
                }
            }
        }
        least
    }
}

/// Least distance (m) between any two pieces of two sets.
pub fn least_distance(a: &[Piece], b: &[Piece]) -> f64 {
    a.iter().flat_map(|a| b.iter().map(|b| a.distance(b))).fold(f64::MAX, f64::min)
}
