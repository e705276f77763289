//! What can be said of a robot from its files alone.

mod draft;
mod folded;
mod pairs;
mod print;
mod srdf_text;
mod survey;

use kinematics::Reach;
use model::{Joint, JointMotion, JointValue, LinkId, Robot, RobotTree, Shape};
use serde::Serialize;

pub use draft::Draft;
pub use folded::folded;
pub use pairs::{Pairs, touching_at_home};
pub use print::text;
pub use srdf_text::{Entries, Reason, srdf_text};
pub use survey::{PairCount, Survey};

/// Everything that `mrtamp robot` tells. Lengths are m, angles rad; what is unlimited is null.
#[derive(Clone, Debug, Serialize)]
pub struct RobotReport {
    /// Name of the URDF file.
    pub name: String,
    /// Links, each followed by those below it.
    pub links: Vec<LinkReport>,
    /// Planned coordinates.
    pub coordinates: Vec<CoordinateReport>,
    /// The hand.
    pub end_effector: EndEffectorReport,
    /// How far the hand gets.
    pub reach: ReachReport,
    /// The arm at `home`.
    pub home: Vec<(String, f64)>,
    /// Number of random configurations.
    pub samples: u64,
    /// Pairs of links not worth testing.
    pub not_tested: Vec<PairReport>,
    /// Pairs of links that touch in some of the configurations.
    pub tested: Vec<PairReport>,
    /// Pairs that the SRDF says not to test, though they touch in some.
    pub doubtful: Vec<PairReport>,
}

/// A link, the joint that moves it, its bodies.
#[derive(Clone, Debug, Serialize)]
pub struct LinkReport {
    /// Name.
    pub name: String,
    /// Number of joints between it and the root.
    pub depth: usize,
    /// Name of its joint; the root has none.
    pub joint: Option<String>,
    /// `fixed`, `revolute`, `prismatic`; with what gives its value.
    pub motion: String,
    /// Kinds of its bodies, such as `hull of 152 points`.
    pub bodies: Vec<String>,
}

/// A planned coordinate.
#[derive(Clone, Debug, Serialize)]
pub struct CoordinateReport {
    /// Name.
    pub name: String,
    /// Least value.
    pub lower: f64,
    /// Greatest value.
    pub upper: f64,
    /// Greatest speed.
    pub velocity: f64,
}

/// The hand.
#[derive(Clone, Debug, Serialize)]
pub struct EndEffectorReport {
    /// Name in the SRDF.
    pub name: String,
    /// Link that grasps are expressed in.
    pub parent_link: String,
    /// Links that may touch what it holds.
    pub touch_links: Vec<String>,
    /// Greatest opening of its sliding fingers; 0 where it has none.
    pub max_opening: f64,
    /// A link that looks like the tool frame.
    pub tool: Option<String>,
}

/// How far the hand's parent link gets.
#[derive(Clone, Debug, Serialize)]
pub struct ReachReport {
    /// The shoulder in the root's frame.
    pub shoulder: [f64; 3],
    /// Bounds on the distance from the shoulder, from lengths and limits.
    pub bounds: [f64; 2],
    /// Least and greatest distance in the samples.
    pub sampled: [f64; 2],
    /// Least and greatest height above the root in the samples.
    pub height: [f64; 2],
}

/// A pair of links.
#[derive(Clone, Debug, Serialize)]
pub struct PairReport {
    /// First link.
    pub link1: String,
    /// Second link.
    pub link2: String,
    /// Why it need not be tested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<Reason>,
    /// Share of the samples in which the two touch.
    pub touching: f64,
}

impl RobotReport {
    /// The report of a robot; `draft` where its SRDF is our own.
    #[must_use]
    pub fn of(robot: &Robot, tree: &RobotTree, draft: Option<&Draft>, survey: &Survey, pairs: &Pairs) -> Self {
        let name = |link: LinkId| robot.links[link.index()].name.clone();
        let hand = &robot.end_effector;
        let reach = Reach::of(robot);
        let tool = Draft::of(tree).and_then(|guess| draft.cloned().unwrap_or(guess).tool);
        let pair = |(links, reason): &((LinkId, LinkId), Option<Reason>)| PairReport {
            link1: name(links.0),
            link2: name(links.1),
            reason: *reason,
            touching: survey.touching(*links),
        };
        let named = |pairs: &[(LinkId, LinkId)]| pairs.iter().map(|links| pair(&(*links, None))).collect();
        Self {
            name: robot.name.clone(),
            links: depth_first(robot).into_iter().map(|link| link_report(robot, link)).collect(),
            coordinates: robot.coordinates.iter().map(coordinate_report).collect(),
            end_effector: EndEffectorReport {
                name: hand.name.clone(),
                parent_link: name(hand.parent_link),
                touch_links: hand.links.iter().map(|link| name(*link)).collect(),
                max_opening: hand.max_opening,
                tool: tool.map(name),
            },
            reach: ReachReport {
                shoulder: reach.root_from_shoulder.coords.into(),
                bounds: [reach.least, reach.greatest],
                sampled: survey.distance,
                height: survey.height,
            },
            home: robot.coordinates[robot.base_len()..]
                .iter()
                .map(|c| c.name.clone())
                .zip(robot.home.clone())
                .collect(),
            samples: survey.samples,
            not_tested: pairs.not_tested.iter().map(|(links, reason)| pair(&(*links, Some(*reason)))).collect(),
            tested: named(&pairs.tested),
            doubtful: named(&pairs.doubtful),
        }
    }
}

/// Links with everything below a link before its next sibling.
fn depth_first(robot: &Robot) -> Vec<LinkId> {
    let (mut order, mut pending) = (Vec::new(), vec![LinkId(0)]);
    while let Some(link) = pending.pop() {
        order.push(link);
        let below = robot.joints.iter().rev().filter(|joint| joint.parent == link);
        pending.extend(below.map(|joint| joint.child));
    }
    order
}

fn coordinate_report(coordinate: &model::Coordinate) -> CoordinateReport {
    let model::Coordinate { name, lower, upper, velocity } = coordinate.clone();
    CoordinateReport { name, lower, upper, velocity }
}

fn link_report(robot: &Robot, link: LinkId) -> LinkReport {
    let joint_of = |link: LinkId| robot.joint_of_link(link).map(|joint| &robot.joints[joint.index()]);
    let joint = joint_of(link);
    let depth = std::iter::successors(joint, |above| joint_of(above.parent)).count();
    let link = &robot.links[link.index()];
    LinkReport {
        name: link.name.clone(),
        depth,
        joint: joint.map(|joint| joint.name.clone()),
        motion: joint.map_or(String::new(), |joint| motion(robot, joint)),
        bodies: link.bodies.iter().map(|body| body_kind(&body.shape)).collect(),
    }
}

fn motion(robot: &Robot, joint: &Joint) -> String {
    let kind = match joint.motion {
        JointMotion::Fixed => return "fixed".to_owned(),
        JointMotion::Revolute { .. } => "revolute",
        JointMotion::Prismatic { .. } => "prismatic",
    };
    let value = match &joint.value {
        JointValue::Coordinate(_) => "planned".to_owned(),
        JointValue::Finger { .. } => "finger".to_owned(),
        JointValue::Mimic { of, .. } => format!("follows {}", robot.joints[of.index()].name),
        JointValue::Constant(value) => format!("stands at {value}"),
    };
    format!("{kind}, {value}")
}

fn body_kind(shape: &Shape) -> String {
    match shape {
        Shape::Box { .. } => "box".to_owned(),
        Shape::Sphere { .. } => "sphere".to_owned(),
        Shape::Cylinder { .. } => "cylinder".to_owned(),
        Shape::Capsule { .. } => "capsule".to_owned(),
        Shape::Hull { points } => format!("hull of {} points", points.len()),
    }
}
