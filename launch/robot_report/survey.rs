//! What many random configurations of a robot show: which links never or always touch, and where the hand gets.

use std::collections::BTreeMap;

use collision::{Geometry, GeometryError};
use contract::{RandomStream, StageKind};
use kinematics::{Reach, link_pose};
use model::{JointMotion, Levels, LinkId, Problem, Robot, RobotId, SearchSettings, Settings};

/// Most parts of the joint ranges that a proof may need.
const PROOF_PARTS: usize = 20_000;
/// Share of the samples from which on a pair is called always touching, as in MoveIt's Setup Assistant.
const ALWAYS: f64 = 0.95;

/// A pair of links and in how many of the samples they were how near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairCount {
    /// Links, the smaller first.
    pub links: (LinkId, LinkId),
    /// Share of samples in which they touched: were nearer than the default clearance.
    pub touching: f64,
    /// Whether it is proven that they touch in no configuration within the limits.
    pub never: bool,
}

impl PairCount {
    /// Whether it touches in practically every configuration.
    #[must_use]
    pub fn is_always(&self) -> bool {
        self.touching >= ALWAYS
    }
}

/// Figures of random configurations, arm joints uniform within their limits, a planar base at its origin.
#[derive(Clone, Debug)]
pub struct Survey {
    /// Number of configurations.
    pub samples: u64,
    /// Pairs of links with bodies that are joined directly, or over links without bodies.
    pub adjacent: Vec<(LinkId, LinkId)>,
    /// All other pairs of links with bodies.
    pub pairs: Vec<PairCount>,
    /// Least and greatest distance (m) of the end effector's parent link from the shoulder.
    pub distance: [f64; 2],
    /// Least and greatest height (m) of the end effector's parent link.
    pub height: [f64; 2],
}

impl Survey {
    /// Surveys a robot.
    ///
    /// # Errors
    /// When a shape is degenerate.
    pub fn of(robot: &Robot, samples: u64) -> Result<Self, GeometryError> {
        let adjacent = adjacent(robot);
        let geometry = Geometry::new(&lone(robot, adjacent.clone(), Settings::default().clearance))?;
        let mut counts: BTreeMap<(LinkId, LinkId), u64> =
            tested(robot, &adjacent).into_iter().map(|links| (links, 0)).collect();
        let shoulder = Reach::of(robot).root_from_shoulder;
        let mut survey = Self {
            samples,
            adjacent,
            pairs: Vec::new(),
            distance: [f64::INFINITY, 0.0],
            height: [f64::INFINITY, f64::NEG_INFINITY],
        };
        for q in configurations(robot, "survey").take(usize::try_from(samples).unwrap_or(usize::MAX)) {
            let hand = link_pose(robot, &q, robot.end_effector.parent_link).translation.vector;
            widen(&mut survey.distance, (hand - shoulder.coords).norm());
            widen(&mut survey.height, hand.z);
            for links in geometry.own_contacts(RobotId(0), &q) {
                counts.entry(links).and_modify(|count| *count += 1);
            }
        }
        let count = |(links, touched): ((LinkId, LinkId), u64)| PairCount {
            links,
            touching: touched as f64 / samples.max(1) as f64,
            never: touched == 0 && geometry.links_never_touch(RobotId(0), links, PROOF_PARTS),
        };
        survey.pairs = counts.into_iter().map(count).collect();
        Ok(survey)
    }

    /// Pairs that cannot be kept apart: adjacent ones and those that always touch.
    #[must_use]
    pub fn hopeless(&self) -> Vec<(LinkId, LinkId)> {
        let always = self.pairs.iter().filter(|count| count.is_always()).map(|count| count.links);
        self.adjacent.iter().copied().chain(always).collect()
    }

    /// Share of samples in which a pair touched; 0 for adjacent ones.
    #[must_use]
    pub fn touching(&self, links: (LinkId, LinkId)) -> f64 {
        self.pairs.iter().find(|count| count.links == links).map_or(0.0, |count| count.touching)
    }
}

/// Random configurations of a robot, the base's coordinates 0; unlimited joints within half a turn.
pub(crate) fn configurations<'a>(robot: &'a Robot, purpose: &str) -> impl Iterator<Item = Vec<f64>> + use<'a> {
    let stream = RandomStream::new(0, StageKind::Roadmap, &[&robot.name], purpose);
    (0..).map(move |index| {
        let mut values = stream.values(index);
        let coordinate = |(i, c): (usize, &model::Coordinate)| {
            let half_turn = std::f64::consts::PI;
            let [lower, upper] = if c.upper.is_finite() { [c.lower, c.upper] } else { [-half_turn, half_turn] };
            if i < robot.base_len() { 0.0 } else { lower + (upper - lower) * values.next_unit() }
        };
        robot.coordinates.iter().enumerate().map(coordinate).collect()
    })
}

fn widen(range: &mut [f64; 2], value: f64) {
    *range = [range[0].min(value), range[1].max(value)];
}

/// A problem with nothing but the robot, in which only these pairs are not tested.
pub(crate) fn lone(robot: &Robot, disabled_pairs: Vec<(LinkId, LinkId)>, clearance: f64) -> Problem {
    Problem {
        name: robot.name.clone(),
        robots: vec![Robot { disabled_pairs, ..robot.clone() }],
        fixed: Vec::new(),
        movable: Vec::new(),
        regions: Vec::new(),
        pairs: Vec::new(),
        orderings: Vec::new(),
        end_policies: vec![model::EndPolicy::default()],
        settings: Settings { clearance, ..Settings::default() },
        levels: Levels::default(),
        search: SearchSettings::default(),
    }
}

/// Pairs of links with bodies but the adjacent ones.
fn tested(robot: &Robot, adjacent: &[(LinkId, LinkId)]) -> Vec<(LinkId, LinkId)> {
    let solid: Vec<LinkId> = (0..robot.links.len()).map(LinkId::at).filter(|link| has_bodies(robot, *link)).collect();
    let pairs = solid.iter().enumerate().flat_map(|(i, a)| solid[i + 1..].iter().map(|b| (*a, *b)));
    pairs.filter(|pair| !adjacent.contains(pair)).collect()
}

fn has_bodies(robot: &Robot, link: LinkId) -> bool {
    !robot.links[link.index()].bodies.is_empty()
}

/// Pairs of links with bodies that a joint joins, directly or over links without bodies, or that are fixed to each other.
fn adjacent(robot: &Robot) -> Vec<(LinkId, LinkId)> {
    let mut pairs = Vec::new();
    for (i, _) in robot.links.iter().enumerate() {
        let (mut at, mut rigid, mut over_bodies) = (LinkId::at(i), true, false);
        let link = at;
        while let Some(joint) = robot.joint_of_link(at).map(|joint| &robot.joints[joint.index()]) {
            rigid &= joint.motion == JointMotion::Fixed;
            at = joint.parent;
            if rigid || !over_bodies {
                pairs.push((at.min(link), at.max(link)));
            }
            over_bodies |= has_bodies(robot, at);
        }
    }
    pairs.extend(siblings(robot));
    pairs.retain(|(a, b)| has_bodies(robot, *a) && has_bodies(robot, *b));
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Pairs of links that are fixed to one link in common.
fn siblings(robot: &Robot) -> Vec<(LinkId, LinkId)> {
    let root = |link: LinkId| {
        let mut at = link;
        while let Some(joint) = robot.joint_of_link(at).map(|joint| &robot.joints[joint.index()]) {
            if joint.motion != JointMotion::Fixed {
                break;
            }
            at = joint.parent;
        }
        at
    };
    let roots: Vec<LinkId> = (0..robot.links.len()).map(|i| root(LinkId::at(i))).collect();
    let pairs = (0..roots.len()).flat_map(|i| (i + 1..roots.len()).map(move |j| (i, j)));
    pairs.filter(|(i, j)| roots[*i] == roots[*j]).map(|(i, j)| (LinkId::at(i), LinkId::at(j))).collect()
}
