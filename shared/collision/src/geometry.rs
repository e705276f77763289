//! Geometry of one problem, built once, and its questions about states, motions and standing objects.

use std::sync::Arc;

use model::{FixedId, LinkId, ObjectId, Pose, Problem, RobotId};
use nalgebra::Point3;

use crate::continuous::Passage;
use crate::hull;
use crate::mover::{Load, Mover};
use crate::obstacle::Obstacle;
use crate::robot_shape::RobotShape;
use crate::separation::{Need, Verdict, judge};
use crate::solid::{Placed, Solid};
use crate::{AllowedContacts, BodyName, Contact, Holding, Motion, Standing};

/// Why no geometry could be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GeometryError {
    /// A shape has no points or a size that is not finite.
    #[error("the shape of {owner} cannot be used: {reason}")]
    Shape {
        /// Whose shape.
        owner: String,
        /// What is wrong with it.
        reason: String,
    },
}

/// A movable object's solid.
#[derive(Clone, Debug)]
struct ObjectShape {
    solid: Arc<Solid>,
    object_from_solid: Pose,
}

/// Shapes, bounds and kinematic chains of a problem. Immutable; share it between threads as you like.
#[derive(Clone, Debug)]
pub struct Geometry {
    problem: Arc<Problem>,
    robots: Vec<RobotShape>,
    objects: Vec<ObjectShape>,
    fixed: Vec<Obstacle>,
    /// For each robot the fixed objects, then those bodies of the others that never move.
    around: Vec<Vec<Obstacle>>,
}

impl Geometry {
    /// Prepares every shape of the problem.
    ///
    /// # Errors
    /// When a shape is degenerate.
    pub fn new(problem: &Problem) -> Result<Self, GeometryError> {
        let mut robots = Vec::new();
        for robot in &problem.robots {
            robots.push(RobotShape::new(robot).map_err(|(link, reason)| GeometryError::Shape {
                owner: format!("link `{link}` of `{}`", robot.name),
                reason,
            })?);
        }
        let bad = |name: &str, reason| GeometryError::Shape { owner: format!("`{name}`"), reason };
        let mut objects = Vec::new();
        for object in &problem.movable {
            let (solid, origin) = Solid::new(&object.body.shape).map_err(|reason| bad(&object.name, reason))?;
            let object_from_solid = hull::shifted(&object.body.owner_from_shape, &origin);
            objects.push(ObjectShape { solid: Arc::new(solid), object_from_solid });
        }
        let mut fixed = Vec::new();
        for (i, object) in problem.fixed.iter().enumerate() {
            for body in &object.bodies {
                let (solid, origin) = Solid::new(&body.shape).map_err(|reason| bad(&object.name, reason))?;
                let world_from_solid = object.world_from_object * hull::shifted(&body.owner_from_shape, &origin);
                fixed.push(Obstacle::new(BodyName::Fixed(FixedId::at(i)), &Arc::new(solid), &world_from_solid));
            }
        }
        let around = problem.robot_ids().map(|id| around(problem, &robots, &fixed, id)).collect();
        Ok(Self { problem: Arc::new(problem.clone()), robots, objects, fixed, around })
    }

    /// The problem it was built from.
    #[must_use]
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// Robot and load against the robot itself and the fixed objects at one configuration, the clearance kept. What never
    /// moves of other robots counts as fixed: what bears the arm of a fixed one, and all of a robot without pairs.
    ///
    /// Links of the end effector may touch the load; so may nothing else. A configuration that is none (wrong length,
    /// not finite) or a grasp that is none is answered with the robot touching itself, here and in every question about
    /// a robot.
    #[must_use]
    pub fn state_contact(
        &self,
        robot: RobotId,
        holding: Option<Holding>,
        q: &[f64],
        allowed: AllowedContacts,
    ) -> Option<Contact> {
        self.passage_contact(robot, holding, q, q, allowed)
    }

    /// Robot and load against a standing object at one configuration. The held object never hits itself.
    #[must_use]
    pub fn state_hits(
        &self,
        robot: RobotId,
        holding: Option<Holding>,
        q: &[f64],
        allowed: AllowedContacts,
        standing: &Standing,
    ) -> Option<Contact> {
        self.passage_hits(robot, holding, q, q, allowed, standing)
    }

    /// A whole straight motion, in continuous time, against the robot itself and the fixed objects.
    ///
    /// `None` is a proof. A contact may be answered for bodies that come as near as 1.25 times the clearance.
    #[must_use]
    pub fn motion_contact(&self, motion: &Motion) -> Option<Contact> {
        self.passage_contact(motion.robot, motion.holding, &motion.from, &motion.to, motion.allowed)
    }

    /// A whole straight motion, in continuous time, against a standing object; see [`Geometry::motion_contact`].
    #[must_use]
    pub fn motion_hits(&self, motion: &Motion, standing: &Standing) -> Option<Contact> {
        self.passage_hits(motion.robot, motion.holding, &motion.from, &motion.to, motion.allowed, standing)
    }

    /// A standing object against the fixed objects, except the bodies of `support` on whose top it stands.
    #[must_use]
    pub fn standing_contact(&self, standing: &Standing, support: Option<FixedId>) -> Option<Contact> {
        let object = self.obstacle(standing);
        let supports = self.bodies_under(support, &[object.least.z]);
        let need = Need::still(self.clearance());
        let touched = self.fixed.iter().enumerate().find(|(k, obstacle)| {
            !supports.contains(k) && judge(object.posed(), obstacle.posed(), &need, &nalgebra::zero()) != Verdict::Clear
        });
        touched.map(|(_, obstacle)| Contact { first: object.name, second: obstacle.name })
    }

    /// Least and greatest corner in the world of a box around a standing object (m).
    #[must_use]
    pub fn standing_bounds(&self, standing: &Standing) -> (Point3<f64>, Point3<f64>) {
        let object = self.obstacle(standing);
        (object.least.into(), object.greatest.into())
    }

    /// Whether two standing objects are nearer than the clearance.
    #[must_use]
    pub fn standings_collide(&self, a: &Standing, b: &Standing) -> bool {
        let need = Need::still(self.clearance());
        let (a, b) = (self.obstacle(a), self.obstacle(b));
        judge(a.posed(), b.posed(), &need, &nalgebra::zero()) != Verdict::Clear
    }

    /// Bodies of the fixed objects.
    pub(crate) fn fixed_obstacles(&self) -> &[Obstacle] {
        &self.fixed
    }

    /// What never moves about a robot: the fixed objects first.
    pub(crate) fn around_robot(&self, robot: RobotId) -> &[Obstacle] {
        &self.around[robot.index()]
    }

    /// An object's solid, and where it is in the object's frame.
    pub(crate) fn object_solid(&self, object: ObjectId) -> (&Solid, &Pose) {
        let shape = &self.objects[object.index()];
        (&shape.solid, &shape.object_from_solid)
    }

    pub(crate) fn robot_shape(&self, robot: RobotId) -> &RobotShape {
        &self.robots[robot.index()]
    }

    pub(crate) fn clearance(&self) -> f64 {
        self.problem.settings.clearance
    }

    pub(crate) fn mover(&self, id: RobotId, holding: Option<Holding>) -> Mover<'_> {
        let robot = self.problem.robot(id);
        let (shape, opening) = (&self.robots[id.index()], robot.end_effector.max_opening);
        let mut mover = Mover { id, robot, shape, load: None, impossible: false, opening };
        if let Some(Holding { object, grasp }) = holding {
            let movable = self.problem.movable.get(object.index());
            let grasps = movable.and_then(|movable| movable.grasps.get(id.index()));
            match (grasps.and_then(|grasps| grasps.get(grasp.index())), self.objects.get(object.index())) {
                (Some(grasp), Some(shape)) => {
                    let link_from_solid = grasp.link_from_object * shape.object_from_solid;
                    mover.load = Some(Load { object, link_from_solid, solid: &shape.solid });
                    mover.opening = grasp.opening;
                }
                _ => mover.impossible = true,
            }
        }
        mover
    }

    pub(crate) fn obstacle(&self, standing: &Standing) -> Obstacle {
        let shape = &self.objects[standing.object.index()];
        let world_from_solid = standing.world_from_object * shape.object_from_solid;
        Obstacle::new(BodyName::Object(standing.object), &shape.solid, &world_from_solid)
    }

    fn passage_contact(
        &self,
        robot: RobotId,
        holding: Option<Holding>,
        from: &[f64],
        to: &[f64],
        allowed: AllowedContacts,
    ) -> Option<Contact> {
        let mover = self.mover(robot, holding);
        let supports = self.supports_of_load(&mover, from, to, allowed.support);
        let obstacles = self.around_robot(robot);
        let clearance = self.clearance();
        Passage { mover, from, to, clearance, obstacles, own: true, touch: None, supports: &supports }.contact()
    }

    pub(crate) fn passage_hits(
        &self,
        robot: RobotId,
        holding: Option<Holding>,
        from: &[f64],
        to: &[f64],
        allowed: AllowedContacts,
        standing: &Standing,
    ) -> Option<Contact> {
        let mover = self.mover(robot, holding);
        let obstacles = &[self.obstacle(standing)];
        let clearance = self.clearance();
        let touch: Option<ObjectId> = allowed.touch;
        Passage { mover, from, to, clearance, obstacles, own: false, touch, supports: &[] }.contact()
    }

    /// Bodies (indices into `fixed`) of the support that the load touches from above at either end of a motion.
    fn supports_of_load(&self, mover: &Mover<'_>, from: &[f64], to: &[f64], support: Option<FixedId>) -> Vec<usize> {
        let coordinates = mover.robot.coordinates.len();
        let (Some(load), Some(_), true) = (&mover.load, support, from.len().min(to.len()) >= coordinates) else {
            return Vec::new();
        };
        let hand = mover.robot.end_effector.parent_link.index();
        let bottom = |q: &[f64]| {
            let world_from_hand = kinematics::link_poses(mover.robot, q, mover.opening)[hand];
            -load.solid.extent(&Placed::at(&(world_from_hand * load.link_from_solid)), &-nalgebra::Vector3::z())
        };
        if from == to {
            return self.bodies_under(support, &[bottom(from)]);
        }
        self.bodies_under(support, &[bottom(from), bottom(to)])
    }

    /// Bodies of the support that a solid whose lowest point is at one of these heights touches from above: nearer than
    /// the clearance, and no deeper than the tolerance of standing.
    pub(crate) fn bodies_under(&self, support: Option<FixedId>, bottoms: &[f64]) -> Vec<usize> {
        let Some(support) = support else {
            return Vec::new();
        };
        let below = self.problem.settings.support_tolerance;
        let above = self.clearance().max(below);
        let carries = |obstacle: &Obstacle| bottoms.iter().any(|bottom| obstacle.carries(*bottom, below, above));
        let of_support = self.fixed.iter().enumerate().filter(|(_, body)| body.name == BodyName::Fixed(support));
        of_support.filter(|(_, body)| carries(body)).map(|(k, _)| k).collect()
    }
}

/// The fixed objects, then those bodies of the robots but `but` that never move.
fn around(problem: &Problem, shapes: &[RobotShape], fixed: &[Obstacle], but: RobotId) -> Vec<Obstacle> {
    let mut around = fixed.to_vec();
    for id in problem.robot_ids().filter(|id| *id != but) {
        let (robot, shape) = (problem.robot(id), &shapes[id.index()]);
        let is_idle = problem.pairs_of_robot(id).next().is_none();
        let poses = kinematics::link_poses(robot, &robot.start, robot.end_effector.max_opening);
        let never_moves =
            |link: LinkId| robot.base.is_none() && shape.chains[link.index()].is_empty() && !robot.is_touch_link(link);
        for body in shape.bodies.iter().filter(|body| is_idle || never_moves(body.link)) {
            let world_from_solid = poses[body.link.index()] * body.link_from_solid;
            around.push(Obstacle::new(BodyName::Link { robot: id, link: body.link }, &body.solid, &world_from_solid));
        }
    }
    around
}
