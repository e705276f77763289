//! The hand alone, wherever the arm puts it: bodies that ride with the end effector's parent link, and the load.
//!
//! What the hand touches, every configuration touches that brings it there.

use model::{AllowedContacts, Holding, Pose, RobotId, Standing};
use nalgebra::Vector3;

use crate::mover::Mover;
use crate::obstacle::Obstacle;
use crate::separation::{Need, Verdict, judge};
use crate::solid::Placed;
use crate::{BodyName, Contact, Geometry};

impl Geometry {
    /// The hand and its load against the fixed objects, the clearance kept, where `world_from_link` puts the end
    /// effector's parent link.
    #[must_use]
    pub fn hand_contact(
        &self,
        robot: RobotId,
        holding: Option<Holding>,
        world_from_link: &Pose,
        allowed: AllowedContacts,
    ) -> Option<Contact> {
        let mover = self.mover(robot, holding);
        let bottom = mover.load.as_ref().map(|load| {
            let placed = Placed::at(&(world_from_link * load.link_from_solid));
            -load.solid.extent(&placed, &-Vector3::z())
        });
        let supports = self.bodies_under(allowed.support, bottom.as_slice());
        let may_touch = |is_load: bool, k: usize| is_load && supports.contains(&k);
        self.hand_against(&mover, world_from_link, self.around_robot(robot), may_touch)
    }

    /// The hand and its load against a standing object; see [`Geometry::hand_contact`].
    #[must_use]
    pub fn hand_hits(
        &self,
        robot: RobotId,
        holding: Option<Holding>,
        world_from_link: &Pose,
        allowed: AllowedContacts,
        standing: &Standing,
    ) -> Option<Contact> {
        let mover = self.mover(robot, holding);
        let (held, object) = (mover.load.map(|load| load.object), Some(standing.object));
        let touched = allowed.touch == object;
        let may_touch = |is_load: bool, _: usize| if is_load { held == object } else { touched };
        self.hand_against(&mover, world_from_link, &[self.obstacle(standing)], may_touch)
    }

    fn hand_against(
        &self,
        mover: &Mover<'_>,
        world_from_link: &Pose,
        obstacles: &[Obstacle],
        may_touch: impl Fn(bool, usize) -> bool,
    ) -> Option<Contact> {
        let parent = mover.robot.end_effector.parent_link.index();
        if mover.impossible {
            return Some(Contact { first: mover.name(0), second: mover.name(0) });
        }
        let still = vec![0.0; mover.robot.coordinates.len()];
        let links = kinematics::link_poses(mover.robot, &still, mover.opening);
        let world_from_still = world_from_link * links[parent].inverse();
        let need = Need::still(self.clearance());
        let chains = &mover.shape.chains;
        for i in 0..mover.len() {
            let (link, link_from_solid) = mover.mount(i);
            if chains[link.index()] != chains[parent] {
                continue;
            }
            let is_load = matches!(mover.name(i), BodyName::Held { .. });
            let is_touch = is_load || mover.shape.bodies[i].touch;
            let placed = Placed::at(&(world_from_still * links[link.index()] * link_from_solid));
            let solid = mover.solid(i);
            let touched = obstacles.iter().enumerate().find(|(k, obstacle)| {
                let allowed = is_touch && may_touch(is_load, *k);
                !allowed
                    && !obstacle.clear_of_ball(&placed.center, solid.radius + need.clearance)
                    && judge((solid, &placed), obstacle.posed(), &need, &Vector3::zeros()) != Verdict::Clear
            });
            if let Some((_, obstacle)) = touched {
                return Some(Contact { first: mover.name(i), second: obstacle.name });
            }
        }
        None
    }
}
