//! A reach: a stand, an arm configuration at the object, and the hand's straight ways off.

use collision::{Contact, Geometry};
use contract::Reach;
use kinematics::{ArmSolver, link_pose};
use model::{AllowedContacts, Configuration, FixedId, Grasp, Holding, Pose, Robot, RobotId, Standing};
use nalgebra::{Translation3, Vector3};

/// Greatest change of a joint (rad or m) between neighbouring configurations of a straight way.
const GREATEST_STEP: f64 = 0.5;
/// Length (m) of the steps of a straight way, before the straightness test.
const STEP: f64 = 0.02;

/// Everything about one end of a pair under one grasp.
pub(crate) struct ReachFinder<'a> {
    pub(crate) geometry: &'a Geometry,
    pub(crate) solver: &'a ArmSolver,
    pub(crate) robot: RobotId,
    pub(crate) holding: Holding,
    pub(crate) grasp: &'a Grasp,
    pub(crate) world_from_object: Pose,
    pub(crate) support: FixedId,
}

/// Why a configuration does not serve.
pub(crate) enum Unfit {
    /// Bodies touch.
    Contact(Contact),
    /// The hand cannot go straight.
    NotStraight,
}

impl ReachFinder<'_> {
    fn model(&self) -> &Robot {
        self.geometry.problem().robot(self.robot)
    }

    /// Pose of the end effector's parent link while it holds the object where it stands.
    pub(crate) fn world_from_link(&self) -> Pose {
        self.world_from_object * self.grasp.link_from_object.inverse()
    }

    /// Whether the robot can stand there with its arm folded, empty-handed and holding.
    pub(crate) fn folded_contact(&self, stand: &[f64]) -> Option<Contact> {
        let robot = self.model();
        let folded = |arm: &[f64]| [stand, arm].concat();
        let none = AllowedContacts::default();
        self.geometry
            .state_contact(self.robot, None, &folded(&robot.home), none)
            .or_else(|| self.geometry.state_contact(self.robot, Some(self.holding), &folded(&robot.carry), none))
    }

    /// What the hand touches at the object or on its short ways, wherever the robot stands and whatever its arm does.
    pub(crate) fn hand_contact(&self) -> Option<Contact> {
        let contact = |(holding, pose, allowed)| self.geometry.hand_contact(self.robot, holding, &pose, allowed);
        self.hand_states().into_iter().find_map(contact)
    }

    /// Whether the hand touches a standing object there.
    pub(crate) fn hand_hits(&self, standing: &Standing) -> bool {
        let hits =
            |(holding, pose, allowed)| self.geometry.hand_hits(self.robot, holding, &pose, allowed, standing).is_some();
        self.hand_states().into_iter().any(hits)
    }

    /// Poses of the hand at the object and along its short ways that every reach goes through.
    fn hand_states(&self) -> Vec<(Option<Holding>, Pose, AllowedContacts)> {
        let settings = &self.geometry.problem().settings;
        let world_from_link = self.world_from_link();
        let back = -(world_from_link.rotation * Vector3::from(self.grasp.approach)) * settings.approach;
        let up = Vector3::z() * settings.lift;
        let mut states =
            vec![(None, world_from_link, self.touching()), (Some(self.holding), world_from_link, self.lifting())];
        let ways = [
            (None, Vector3::zeros(), back, self.touching()),
            (Some(self.holding), Vector3::zeros(), up, self.lifting()),
            (Some(self.holding), up, back, AllowedContacts::default()),
        ];
        for (holding, from, by, allowed) in ways {
            let steps = least_steps(&by);
            for i in 1..=steps {
                let shift = Translation3::from(from + by * (i as f64 / steps as f64));
                states.push((holding, shift * world_from_link, allowed));
            }
        }
        states
    }

    /// Completes an arm configuration at the object to a reach.
    pub(crate) fn complete(&self, stand: &[f64], arm: Vec<f64>) -> Result<Reach, Unfit> {
        let at_object = [stand, &arm].concat();
        self.free(None, &at_object, self.touching())?;
        self.free(Some(self.holding), &at_object, self.lifting())?;
        let settings = &self.geometry.problem().settings;
        let back = -(self.world_from_link().rotation * Vector3::from(self.grasp.approach));
        let approach = self.straight(stand, &at_object, &[back * settings.approach])?;
        let up = Vector3::z() * settings.lift;
        let raise = self.straight(stand, &at_object, &[up])?;
        let lift_up = raise.len() - 1;
        let mut lift = raise;
        let withdraw = self.straight_from(stand, &lift[lift_up], up, back * settings.approach)?;
        lift.extend(withdraw.into_iter().skip(1));
        for q in &approach[1..] {
            self.free(None, q, self.touching())?;
        }
        for (i, q) in lift.iter().enumerate().skip(1) {
            let allowed = if i <= lift_up { self.lifting() } else { AllowedContacts::default() };
            self.free(Some(self.holding), q, allowed)?;
        }
        Ok(Reach {
            stand: stand.to_vec(),
            at_object,
            approach,
            lift,
            lift_up: u32::try_from(lift_up).unwrap_or(u32::MAX),
            support: self.support,
        })
    }

    fn touching(&self) -> AllowedContacts {
        AllowedContacts { touch: Some(self.holding.object), support: None }
    }

    fn lifting(&self) -> AllowedContacts {
        AllowedContacts { touch: None, support: Some(self.support) }
    }

    fn free(&self, holding: Option<Holding>, q: &[f64], allowed: AllowedContacts) -> Result<(), Unfit> {
        self.geometry
            .state_contact(self.robot, holding, q, allowed)
            .map_or(Ok(()), |contact| Err(Unfit::Contact(contact)))
    }

    fn straight(
        &self,
        stand: &[f64],
        from: &Configuration,
        by: &[Vector3<f64>; 1],
    ) -> Result<Vec<Configuration>, Unfit> {
        self.straight_from(stand, from, Vector3::zeros(), by[0])
    }

    /// Configurations along the hand's straight way from `offset` to `offset + by` (m, world), orientation kept. Steps are
    /// halved until the hand, moving straight in configuration space between them, stays within `straightness`.
    fn straight_from(
        &self,
        stand: &[f64],
        from: &Configuration,
        offset: Vector3<f64>,
        by: Vector3<f64>,
    ) -> Result<Vec<Configuration>, Unfit> {
        let mut steps = least_steps(&by);
        for _ in 0..3 {
            let way = self.follow(stand, from, offset, by, steps)?;
            if self.is_straight(&way, offset, by) {
                return Ok(way);
            }
            steps *= 2;
        }
        Err(Unfit::NotStraight)
    }

    fn follow(
        &self,
        stand: &[f64],
        from: &Configuration,
        offset: Vector3<f64>,
        by: Vector3<f64>,
        steps: usize,
    ) -> Result<Vec<Configuration>, Unfit> {
        let mut way = vec![from.clone()];
        for i in 1..=steps {
            let shift = Translation3::from(offset + by * (i as f64 / steps as f64));
            let arm = &way[i - 1][stand.len()..];
            let next = self
                .solver
                .follow(self.model(), stand, &(shift * self.world_from_link()), arm, GREATEST_STEP)
                .ok_or(Unfit::NotStraight)?;
            way.push([stand, &next].concat());
        }
        Ok(way)
    }

    fn is_straight(&self, way: &[Configuration], offset: Vector3<f64>, by: Vector3<f64>) -> bool {
        let robot = self.model();
        let steps = (way.len() - 1) as f64;
        let origin = self.world_from_link().translation.vector + offset;
        way.windows(2).enumerate().all(|(i, step)| {
            let middle: Configuration = step[0].iter().zip(&step[1]).map(|(a, b)| f64::midpoint(*a, *b)).collect();
            let hand = link_pose(robot, &middle, robot.end_effector.parent_link).translation.vector;
            let wanted = origin + by * ((i as f64 + 0.5) / steps);
            (hand - wanted).norm() <= self.geometry.problem().settings.straightness
        })
    }
}

/// Steps of a straight way at the least.
fn least_steps(by: &Vector3<f64>) -> usize {
    (by.norm() / STEP).ceil().max(1.0) as usize
}
